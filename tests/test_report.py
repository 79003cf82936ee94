"""The report: what it says is so, what stands out is drawn, and the page needs nobody."""

import json
import math
import re
import tracemalloc
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from vsensor.cli.main import app
from vsensor.errors import InputError
from vsensor.messages import BIT_ESTIMATE, SURFACE_SPEED, Estimate, Sample, Status
from vsensor.messages.vsensor_pb2 import GOOD
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter
from vsensor.report import plots
from vsensor.report.figures import counted, rolled, skill, sticking, worst_window
from vsensor.report.gather import Story, gather
from vsensor.report.grown import Grown
from vsensor.report.plots import portrait
from vsensor.report.report import report
from vsensor.report.thin import thinned

GOLDEN = Path(__file__).parents[1] / "recordings" / "stick_slip.mcap"
NS = 1_000_000_000
values = st.floats(-1e6, 1e6) | st.just(math.nan)


def story(seconds: float, bit: np.ndarray, top: float = 10.0, rate: int = 50) -> Story:
    """A story in which the bit does this, confirmed a second late; now is half a rad/s above it."""
    count = round(seconds * rate)
    time_ns = np.arange(count) * (NS // rate)
    names = ("confirmed_bit_torque_nm", "top_torque_nm", "now_bit_torque_nm", "forecast_bit_torque_nm")
    columns = {
        **{name: np.full(count, 1000.0) for name in names},
        "confirmed_bit_speed_rad_s": bit,
        "top_speed_rad_s": np.full(count, top),
        "now_bit_speed_rad_s": np.roll(bit, -rate) + 0.5,
        "forecast_bit_speed_rad_s": np.roll(bit, -2 * rate) - 2.0,
        "quality": np.ones(count),
    }
    return Story(columns, time_ns, time_ns - NS, time_ns + NS, np.empty(0))


@given(st.lists(values, min_size=1, max_size=400), st.integers(1, 40))
def test_thinned_every_stretch_keeps_its_least_and_greatest(told: list[float], bins: int) -> None:
    series = np.array(told)
    time, (thin,) = thinned(np.arange(len(series), dtype=np.float64), series, bins=bins)
    assert len(thin) == len(time) <= max(2 * bins, 2)
    assert np.all(np.diff(time) >= 0)
    if len(series) <= 2 * bins:
        assert thin.tobytes() == series.tobytes()
        return
    width = -(-len(series) // bins)
    for k, start in enumerate(range(0, len(series), width)):
        stretch = series[start : start + width]
        known = stretch[np.isfinite(stretch)]
        pair = thin[2 * k : 2 * k + 2]
        if len(known):
            assert (np.nanmin(pair), np.nanmax(pair)) == (known.min(), known.max())
        else:
            assert np.isnan(pair).all()


@given(st.lists(st.floats(-20, 40) | st.just(math.nan), min_size=20, max_size=150), st.integers(1, 12))
def test_severity_is_that_of_its_formula(told: list[float], window: int) -> None:
    """Naive twin: each window gathered by itself, at five samples a second."""
    speed = np.array(told)
    time_ns = np.arange(len(speed)) * (NS // 5)
    found = rolled(time_ns, speed, float(window))
    seconds = [speed[k : k + 5] for k in range(0, len(speed), 5)]
    window = min(window, len(seconds))
    expected = []
    for first in range(len(seconds) - window + 1):
        own = seconds[first : first + window]
        known = np.concatenate([each[np.isfinite(each)] for each in own])
        half = 2 * sum(bool(np.isfinite(each).any()) for each in own) >= window
        if half and len(known) and abs(known.mean()) >= 0.1:
            expected.append((known.max() - known.min()) / (2 * abs(known.mean())))
        else:
            expected.append(math.nan)
    np.testing.assert_allclose(found.value, expected, rtol=1e-9)
    assert found.time_ns.tolist() == [(first + window) * NS for first in range(len(expected))]


def test_the_worst_minute_is_where_the_bit_swung() -> None:
    time = np.arange(0, 300, 0.02)
    bit = 10 + np.where((time > 150) & (time < 200), 9, 1) * np.sin(time)
    begin, end = worst_window(story(300, bit))
    assert end - begin == 60 * NS
    assert begin / NS < 152
    assert end / NS > 198


def test_a_bit_that_stands_while_the_top_turns_is_stuck() -> None:
    time = np.arange(0, 100, 0.02)
    bit = np.where((time % 10) < 3, 0.0, 14.0)
    told = sticking(story(100, bit))
    assert told.share == pytest.approx(0.3, abs=1e-3)
    assert told.times == 10
    assert told.longest_s == pytest.approx(2.98)
    assert math.isnan(sticking(story(100, 0 * bit, top=0.0)).share)


def test_skill_is_what_was_said_less_what_was_confirmed() -> None:
    bit = 10 + np.sin(np.arange(0, 100, 0.02))
    told = skill(story(100, bit))
    assert told.ahead_s.tolist() == [0.0, 1.0]
    # The last seconds of `roll` come from the beginning: they are beyond what is confirmed.
    assert told.speed_rad_s == pytest.approx([0.5, 2.0], abs=1e-6)
    assert told.torque_nm == pytest.approx([0.0, 0.0])


def told_skill(*rows: tuple[float, float, float]) -> Status:
    status = Status()
    for ahead, speed, torque in rows:
        status.skill.add(ahead_s=ahead, speed_rms_rad_s=speed, torque_rms_nm=torque)
    return status


def test_what_the_sensor_counted_of_itself_is_summed_up_by_horizon() -> None:
    warming_up = Status()
    warming_up.skill.add(ahead_s=0.0)
    shorter = told_skill((0.0, 9.0, 900.0), (0.7, 9.0, 900.0))
    told = [told_skill((0.0, 3.0, 30.0), (0.8, 6.0, 60.0)), told_skill((0.0, 4.0, 40.0), (0.8, 8.0, 80.0))]
    summed = counted([Status(), warming_up, shorter, *told])
    assert summed.ahead_s.tolist() == [0.0, 0.8]
    assert summed.speed_rad_s == pytest.approx([math.sqrt(12.5), math.sqrt(50)])
    assert summed.torque_nm == pytest.approx([math.sqrt(1250), math.sqrt(5000)])
    assert not len(counted([Status(), warming_up]).ahead_s)


def test_the_page_of_a_recorded_session_says_what_happened() -> None:
    html = report(Session(GOLDEN))
    told = gather(Session(GOLDEN))
    share = sticking(told).share
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


def test_estimates_that_never_got_warm_are_told_so(tmp_path: Path) -> None:
    session = written(
        tmp_path / "a.mcap", [(BIT_ESTIMATE, Estimate(number=0, time_ns=5).SerializeToString())]
    )
    assert "nothing is known of the bit" in report(session)


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


@given(st.lists(st.lists(st.floats(), max_size=50), max_size=30))
def test_a_column_grown_piece_by_piece_is_all_of_them(pieces: list[list[float]]) -> None:
    column = Grown(np.float64)
    for piece in pieces:
        column.add(np.array(piece))
    together = np.array([value for piece in pieces for value in piece])
    assert len(column) == len(together)
    assert column.whole().tobytes() == together.tobytes()


def test_a_column_takes_little_more_memory_than_its_numbers() -> None:
    """Nor does the growing: an eighth more than there is, and one piece."""
    piece = np.zeros(10_000)
    tracemalloc.start()
    column = Grown(np.float64)
    for _ in range(200):
        column.add(piece)
    size = column.whole().nbytes
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert size == 200 * piece.nbytes
    assert most < 1.2 * size


@pytest.mark.parametrize("count", [0, 1, 7, 350])
def test_the_portrait_counts_every_tick_however_many_at_a_time(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    bit = 10 + 5 * np.sin(np.arange(count + 1.0))
    bit[-1] = np.nan
    told = story(len(bit) / 50, bit)
    whole = portrait(told, None)
    monkeypatch.setattr(plots, "_AT_ONCE", 100)
    assert portrait(told, None) == whole
    counted = [10**shade for row in whole["data"][0]["z"] for shade in row if shade is not None]
    assert sum(counted) == pytest.approx(count, rel=0.01)
