"""The report's page: what it says is so, and it needs nobody."""

import json
import re
import tracemalloc
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.reported import NS
from vsensor.cli.main import app
from vsensor.errors import InputError
from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    SURFACE_SPEED,
    Estimate,
    Event,
    Sample,
    Status,
)
from vsensor.messages.vsensor_pb2 import GOOD
from vsensor.recording.reader import Session
from vsensor.recording.recover import recover
from vsensor.recording.writer import SessionWriter
from vsensor.report.gather import gather
from vsensor.report.report import report

GOLDEN = Path(__file__).parents[1] / "recordings" / "stick_slip.mcap"


def test_the_page_of_a_recorded_session_says_what_happened() -> None:
    html = report(Session(GOLDEN))
    told = gather(Session(GOLDEN))
    share = told.stands.told().share
    assert f"<h1>Stick-slip: the bit stood still {share:.0%} of the time" in html
    for heading in ("The whole session", "Along the string", "How well it was foretold", "Losses", "Events"):
        assert f"<h2>{heading}</h2>" in html
    plots = plots_of(html)
    assert set(plots) == {"over-time", "closely", "portrait", "by-horizon", "along", "lateness"}
    assert all(f'id="{name}"' in html for name in plots)
    assert "(ω_max − ω_min) / (2 ω_mean)" in html


def plots_of(html: str) -> dict[str, object]:
    found = re.search(r'<script type="application/json" id="plots">(.*?)</script>', html, re.DOTALL)
    assert found
    plots: dict[str, object] = json.loads(found[1])
    return plots


def test_the_page_asks_nobody_for_anything() -> None:
    html = report(Session(GOLDEN))
    scripts = [found.span() for found in re.finditer(r"<script>.*?</script>", html, re.DOTALL)]
    bounds = [0, *(place for span in scripts for place in span), len(html)]
    own = "".join(html[start:end] for start, end in list(pairwise(bounds))[::2])
    assert not re.search(r"""(src|href)\s*=|@import|url\(""", own)
    assert "<script src" not in html


def written(path: Path, told: list[tuple[str, bytes]], rig: str = "r") -> Session:
    with SessionWriter(path, configuration="", metadata={"rig": rig}, compression="none") as writer:
        for number, (topic, data) in enumerate(told):
            writer.write(topic, data, number, number)
    return Session(path)


def test_estimates_alone_are_enough(tmp_path: Path) -> None:
    estimates = [
        Estimate(
            number=k, time_ns=k * NS // 10, confirmed_bit_speed_rad_s=9.0, top_speed_rad_s=9.0, quality=GOOD
        )
        for k in range(600)
    ]
    session = written(tmp_path / "a.mcap", [(BIT_ESTIMATE, each.SerializeToString()) for each in estimates])
    html = report(session)
    assert "<h1>Smooth: the bit turned with the top, at 86 rpm" in html
    assert "not counted" in html
    assert "The session holds no profiles of the string." in html


def bit_at(speeds: "list[float] | np.ndarray") -> list[tuple[str, bytes]]:
    """Estimates of a bit that is confirmed to turn so, ten a second, under a top at 86 rpm."""
    return [
        (
            BIT_ESTIMATE,
            Estimate(
                number=k,
                time_ns=k * NS // 10,
                confirmed_bit_speed_rad_s=speed,
                top_speed_rad_s=9.0,
                quality=GOOD,
            ).SerializeToString(),
        )
        for k, speed in enumerate(speeds)
    ]


def test_a_bit_that_only_stood_has_not_slipped(tmp_path: Path) -> None:
    html = report(written(tmp_path / "a.mcap", bit_at([-1e-4] * 30)))
    assert "<h1>The bit stood still in all that is known of it, 2.9 s on end; the top turned" in html
    assert "-0 rpm" not in html


def test_half_a_swing_is_not_called_smooth(tmp_path: Path) -> None:
    html = report(written(tmp_path / "a.mcap", bit_at(np.linspace(16.0, 26.0, 20))))
    assert "<h1>Bit and top did not turn alike: the bit ran between 153 and 248 rpm; the top" in html


def status(second: int, uptime_s: float, lost: int, foretold: int) -> tuple[str, bytes]:
    """What a daemon tells that has received a hundred samples a second."""
    told = Status(time_ns=second * NS, uptime_s=uptime_s, slots_skipped=lost, restarts=1)
    told.sticks_foretold, told.sticks_missed, told.stick_lead_s = foretold, 1, 0.5
    told.channels.add(channel="surface/torque", received=round(100 * uptime_s), lost=lost, doubled=2)
    return SENSOR_STATUS, told.SerializeToString()


def keys_of(html: str) -> dict[str, tuple[str, str]]:
    found = re.findall(r"<span>([^<]*)</span><b>([^<]*)</b><span>([^<]*)</span>", html)
    return {name: (value, beside) for name, value, beside in found}


@pytest.mark.parametrize(
    ("began_s", "samples", "sticks", "skipped"),
    [(3600.0, "of 307", "4 of 4", 7), (0.0, "of 308", "9 of 10", 8)],
)
def test_a_part_tells_what_was_lost_in_it_not_since_the_sensor_began(
    tmp_path: Path, began_s: float, samples: str, sticks: str, skipped: int
) -> None:
    first, last = status(1, began_s, 1, 5), status(4, began_s + 3, 8, 9)
    html = report(written(tmp_path / "a.mcap", [*bit_at([9.0] * 40), first, last]))
    assert keys_of(html)["samples lost"] == (f"{skipped}", f"{samples}; unknown messages not recorded")
    assert keys_of(html)["sticks foretold"] == (sticks, "0 in vain; 0.5 s ahead on average")
    assert f"<td>slots skipped by the loop</td><td>{skipped}</td>" in html
    assert ("doubled" in html.split("Losses")[1].split("lateness")[0]) == (began_s == 0)


def test_estimates_that_never_got_warm_are_told_so(tmp_path: Path) -> None:
    session = written(
        tmp_path / "a.mcap", [(BIT_ESTIMATE, Estimate(number=0, time_ns=5).SerializeToString())]
    )
    html = report(session)
    assert "nothing is known of the bit" in html
    words = re.sub(r"<[^>]+>", " ", re.sub(r"<(script|style).*?</\1>", "", html, flags=re.DOTALL))
    assert not re.search(r"\bnan\b", words)


def test_what_is_missing_of_a_torn_session_and_of_a_mended_one_is_told(tmp_path: Path) -> None:
    whole = written(tmp_path / "a.mcap", bit_at([9.0] * 600))
    assert "The session is" not in report(whole)
    (tmp_path / "torn.mcap").write_bytes(whole.path.read_bytes()[:-5000])
    torn = Session(tmp_path / "torn.mcap")
    assert "The session is torn, damaged or still being written: " in report(torn)
    html = report(Session(recover(torn.path, tmp_path / "mended.mcap").path))
    assert re.search(r"The session was recovered from torn\.mcap, of which .* could not be read", html)


def test_names_cannot_become_part_of_the_page(tmp_path: Path) -> None:
    estimate = Estimate(number=0, time_ns=5).SerializeToString()
    html = report(written(tmp_path / "a.mcap", [(BIT_ESTIMATE, estimate)], rig="</script><b onclick=x>"))
    assert "<b onclick" not in html
    assert "&lt;b onclick=x&gt;" in html


def test_without_estimates_there_is_nothing_to_report(tmp_path: Path) -> None:
    session = written(tmp_path / "a.mcap", [(SURFACE_SPEED, Sample(value=1).SerializeToString())])
    with pytest.raises(InputError, match=r"holds no bit/estimate to report on; .*vsensor estimate"):
        report(session)


def test_the_command_writes_the_page(tmp_path: Path) -> None:
    page = tmp_path / "a.html"
    done = CliRunner().invoke(app, ["report", str(GOLDEN), "-o", str(page)])
    assert done.exit_code == 0, done.output
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    wrong = CliRunner().invoke(app, ["report", str(GOLDEN), "-o", str(tmp_path / "a.pdf")])
    assert wrong.exit_code == 2
    assert "must end in .html" in wrong.output


def test_of_very_many_events_the_first_are_told_and_the_others_counted(tmp_path: Path) -> None:
    estimate = (BIT_ESTIMATE, Estimate(number=0, time_ns=0).SerializeToString())
    events = [
        (SENSOR_EVENT, Event(time_ns=k * NS, text=f"event {k}").SerializeToString()) for k in range(100)
    ]
    html = report(written(tmp_path / "a.mcap", [estimate, *events]))
    assert "<td>59.0 s</td><td>event 59</td>" in html
    assert "event 60" not in html
    assert "<td>40 more</td>" in html


def test_a_longer_session_takes_no_more_memory(tmp_path: Path) -> None:
    """But for 48 bytes a second: the ticks themselves would take 9600."""

    def peak(count: int) -> int:
        bit = 10 + 5 * np.sin(np.arange(count) / 30)
        estimates = (
            Estimate(
                number=k,
                time_ns=k * NS // 100,
                confirmed_bit_speed_rad_s=speed,
                confirmed_bit_torque_nm=900 * speed,
                top_speed_rad_s=9.0,
                top_torque_nm=9e3,
                now_bit_speed_rad_s=speed,
                forecast_bit_speed_rad_s=speed,
                forecast_time_ns=k * NS // 100,
            )
            for k, speed in enumerate(bit.tolist())
        )
        path = tmp_path / f"{count}.mcap"
        session = written(path, [(BIT_ESTIMATE, each.SerializeToString()) for each in estimates])
        report(session)  # what is made once and kept
        tracemalloc.start()
        report(session)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    few, many = peak(20_000), peak(100_000)
    assert many < few + 100 * 800 + 500_000
