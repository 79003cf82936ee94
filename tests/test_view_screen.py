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
from vsensor.view.blueprint import TIMELINE, blueprint
from vsensor.view.live import Live
from vsensor.view.place import Place, ViewError
from vsensor.view.screen import Screen
from vsensor.view.stream import Stream

RPM = 60 / (2 * math.pi)


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
    with Screen("t", blueprint(60.0), Place("file", save=path)) as screen:
        for _, message in messages(400):
            stream.take(message)
        screen.send(stream.batches())
    found = batches(path)
    confirmed = found["/speed/bit/confirmed"]
    times = [t.value for c in confirmed for t in c[TIMELINE]]
    assert len(times) == 400
    truth = [bit_speed((time_ns - BEGUN_NS) / 1e9) * RPM for time_ns in times]
    np.testing.assert_allclose(np.ravel(column(confirmed, "Scalars")), truth, atol=1e-6)
    assert {len(row) for row in column(found["/speed/band/now"], "Scalars")} == {2}
    assert "stuck begins" in str(column(found["/log"], "text"))
    assert column(found["/event/stuck"], "state")[:3] == [["stuck"], [""], ["stuck"]]
    assert "Bit" in str(column(found["/panel"], "text"))


def test_a_file_that_cannot_be_written_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "nowhere" / "view.rrd"
    with pytest.raises(ViewError, match="nowhere"), Screen("t", blueprint(60.0), Place("file", save=path)):
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
    with Screen("t", blueprint(60.0), Place("file", save=path)) as screen:
        Live(Ears(*heard), screen, Stream).turn()  # type: ignore[arg-type]
    for file, count, begun_ns in ((path, 50, BEGUN_NS), (tmp_path / "view-2.rrd", 70, years_before)):
        times = [t.value for c in batches(file)["/speed/at_surface"] for t in c[TIMELINE]]
        assert (len(times), min(times)) == (count, begun_ns)
    assert len(RrdReader(path).blueprints()) == len(RrdReader(tmp_path / "view-2.rrd").blueprints()) == 1


def views(part: object) -> list[rrb.api.View]:
    if isinstance(part, rrb.api.View):
        return [part]
    return [view for inner in part.contents for view in views(inner)]  # type: ignore[attr-defined]


def test_everything_that_is_sent_is_shown_somewhere() -> None:
    stream = Stream()
    for _, message in messages(300):
        stream.take(message)
    sent = {batch.entity for batch in stream.batches()}
    shown = views(blueprint(60.0).root_container)
    roots = {str(root).removesuffix("/**") for view in shown for root in _roots(view)}
    assert not {entity for entity in sent if not any(entity.startswith(root) for root in roots)}


def _roots(view: rrb.api.View) -> list[str]:
    return [str(view.origin)] if view.contents == "$origin/**" else [str(part) for part in view.contents]  # type: ignore[union-attr]


def test_the_lines_of_the_bit_are_drawn_above_its_bands_and_those_above_the_surface() -> None:
    names = [series.surface(series.SPEED), series.band(series.SPEED, "now"), series.bit(series.SPEED, "now")]
    assert names == sorted(names)
