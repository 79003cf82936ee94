"""What reaches Rerun: read back from its own files."""

import math
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
import rerun.blueprint as rrb
from rerun.chunk import RrdReader

from tests.view_rig import BEGUN_NS, bit_speed, messages
from vsensor.view import series
from vsensor.view.blueprint import TABS, TIMELINE, USUAL, Reach, blueprint
from vsensor.view.live import Live, Show
from vsensor.view.place import Place, ViewError
from vsensor.view.readings import KINDS
from vsensor.view.screen import Screen
from vsensor.view.stream import Stream
from vsensor.view.units import Units

RPM = 60 / (2 * math.pi)


def layout(reach: Reach) -> rrb.Blueprint:
    return blueprint(30.0, Units(), reach)


def batches(path: Path) -> dict[str, list[pa.RecordBatch]]:
    """Every chunk of data on the source's clock, by entity."""
    found = defaultdict(list)
    for chunk in RrdReader(path).stream():
        if TIMELINE in chunk.timeline_names:
            found[chunk.entity_path].append(chunk.to_record_batch())
    return found


def column(chunks: list[pa.RecordBatch], name: str) -> list[Any]:
    return [
        value for chunk in chunks for n in chunk.schema.names if name in n for value in chunk[n].to_pylist()
    ]


def test_a_file_holds_everything_that_came_at_its_time_and_in_its_unit(tmp_path: Path) -> None:
    path = tmp_path / "view.rrd"
    stream = Stream()
    with Screen("t", layout, Place("file", save=path), live=False) as screen:
        for _, message in messages(400):
            stream.take(message)
        screen.send(stream.batches())
    found = batches(path)
    confirmed = found["/speed/bit/confirmed"]
    times = [t.value for c in confirmed for t in c[TIMELINE]]
    assert len(times) == 400
    truth = [bit_speed((time_ns - BEGUN_NS) / 1e9) * RPM for time_ns in times]
    np.testing.assert_allclose(np.ravel(column(confirmed, "values")), truth, atol=1e-6)
    bands = np.ravel(column(found["/speed/bit/now"], "variances"))
    np.testing.assert_allclose(bands, (2 * 0.4 * RPM) ** 2)
    assert "stuck: the bit stands still" in str(column(found["/log"], "text"))
    assert column(found["/sensor/stuck"], "state")[:3] == [["stuck"], [""], ["stuck"]]
    assert "speed ± 2σ" in str(column(found["/answers"], "text"))


def test_a_file_that_cannot_be_written_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "nowhere" / "view.rrd"
    with pytest.raises(ViewError, match="nowhere"), Screen("t", layout, Place("file", save=path), live=False):
        pass


class Ears:
    """Has heard everything already."""

    def __init__(self, *heard: object) -> None:
        self._heard = heard

    def drain(self) -> tuple[object, ...]:
        return self._heard


def test_when_time_falls_back_another_recording_begins(tmp_path: Path) -> None:
    path = tmp_path / "view.rrd"
    years_before = BEGUN_NS - 10 * 365 * 86400 * 1_000_000_000
    heard = [m for _, m in messages(50)] + [m for _, m in messages(70, years_before)]
    with Screen("t", layout, Place("file", save=path), live=False) as screen:
        Live(Ears(*heard), Show(screen, Stream)).turn()  # type: ignore[arg-type]
    for file, count, begun_ns in ((path, 50, BEGUN_NS), (tmp_path / "view-2.rrd", 70, years_before)):
        times = [t.value for c in batches(file)["/speed/at_surface"] for t in c[TIMELINE]]
        assert (len(times), min(times)) == (count, begun_ns)
        assert RrdReader(file).blueprints()


def views(part: object) -> list[rrb.api.View]:
    if isinstance(part, rrb.api.View):
        return [part]
    return [view for inner in part.contents for view in views(inner)]  # type: ignore[attr-defined]


def test_everything_that_is_sent_is_shown_somewhere() -> None:
    stream = Stream()
    for _, message in messages(300):
        stream.take(message)
    sent = {batch.entity for batch in stream.batches()}
    shown = views(layout(USUAL).root_container)
    roots = {str(root).removesuffix("/**") for view in shown for root in _roots(view)}
    assert not {entity for entity in sent if not any(entity.startswith(root) for root in roots)}


def _roots(view: rrb.api.View) -> list[str]:
    return [str(view.origin)] if "$origin" in str(view.contents) else [str(part) for part in view.contents]  # type: ignore[union-attr]


def test_the_bit_is_drawn_above_the_surface_and_the_present_on_top() -> None:
    plot = series.SPEED
    names = [series.surface(plot), *(series.bit(plot, kind) for kind in KINDS), series.present(plot)]
    assert names[0] == min(names)
    assert names[-1] == max(names)


def test_three_tabs_of_which_the_one_that_is_asked_for_is_open() -> None:
    for number, tab in enumerate(TABS):
        tabs = blueprint(30.0, Units(), tab=tab).root_container
        assert [part.name for part in tabs.contents] == ["Driller", "Engineer", "Service"]
        assert tabs.active_tab == number


def test_the_layout_is_sent_again_only_where_the_reach_has_changed(tmp_path: Path) -> None:
    path = tmp_path / "view.rrd"
    asked: list[Reach] = []

    def noted(reach: Reach) -> rrb.Blueprint:
        asked.append(reach)
        return layout(reach)

    with Screen("t", noted, Place("file", save=path), live=False) as screen:
        for reach in (Reach(2.0, 0.5), Reach(2.01, 0.5), Reach(2.5, 0.5)):
            screen.fit(reach)
    assert asked == [USUAL, Reach(2.0, 0.5), Reach(2.5, 0.5)]
