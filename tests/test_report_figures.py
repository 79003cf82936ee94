"""The report's figures: those of their formulas, in however many pieces a session comes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.reported import NS, pieces, ticks
from vsensor.messages import Status
from vsensor.report.figures import Extent, Stands, Sticking
from vsensor.report.foretold import Foretold, Skill, counted
from vsensor.report.seconds import Seconds
from vsensor.report.ticks import Ticks

speeds = st.lists(st.floats(-20, 40) | st.just(math.nan), min_size=20, max_size=150)
cuts = st.lists(st.integers(0, 150), max_size=6)


def seconds_of(told: Ticks, at: list[int]) -> Seconds:
    seconds = Seconds()
    for piece in pieces(told, at):
        seconds.add(piece)
    return seconds


def sticking(told: Ticks, at: list[int]) -> Sticking:
    stands = Stands()
    for piece in pieces(told, at):
        stands.add(piece)
    return stands.told()


def skill(told: Ticks, at: list[int]) -> Skill:
    foretold = Foretold()
    for piece in pieces(told, at):
        foretold.add(piece)
    return foretold.skill()


@given(speeds, st.integers(1, 12), cuts)
def test_severity_is_that_of_its_formula(told: list[float], window: int, at: list[int]) -> None:
    """Naive twin: each window gathered by itself, at five samples a second."""
    speed = np.array(told)
    found = seconds_of(ticks(speed, rate=5, begin_ns=NS), at).severity(float(window))
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


@pytest.mark.parametrize("leap_s", [10**9, -(10**9), 100])
def test_a_clock_that_leaps_parts_a_session_and_costs_nothing(leap_s: int) -> None:
    before, after = (10 + np.sin(k + np.arange(0, 200, 0.02)) for k in (0.0, 1.0))
    parts = [ticks(before, begin_ns=NS), ticks(after, begin_ns=(201 + leap_s) * NS)]
    seconds = Seconds()
    for part in parts:
        seconds.add(part)
    found = seconds.severity(20.0)
    assert np.all(np.diff(found.time_ns) > 0)
    assert len(found.value) < 500
    for part in parts:
        alone = seconds_of(part, []).severity(20.0)
        own = np.isin(found.time_ns, alone.time_ns)
        assert found.value[own].tolist() == pytest.approx(alone.value.tolist())


def test_the_worst_minute_is_where_the_bit_swung() -> None:
    time = np.arange(0, 300, 0.02)
    bit = 10 + np.where((time > 150) & (time < 200), 9, 1) * np.sin(time)
    begin, end = seconds_of(ticks(bit, begin_ns=NS), [7000, 9000]).worst()
    assert end - begin == 60 * NS
    assert begin / NS < 152
    assert end / NS > 198


def test_of_a_session_shorter_than_a_minute_all_is_worst() -> None:
    assert seconds_of(ticks(np.zeros(500), begin_ns=NS), []).worst() == (0, 10 * NS)


def test_a_bit_that_stands_while_the_top_turns_is_stuck() -> None:
    time = np.arange(0, 100, 0.02)
    bit = np.where((time % 10) < 3, 0.0, 14.0)
    told = sticking(ticks(bit), [])
    assert told.share == pytest.approx(0.3, abs=1e-3)
    assert told.times == 10
    assert told.longest_s == pytest.approx(2.98)
    assert math.isnan(sticking(ticks(0 * bit, top=0.0), []).share)


@given(st.lists(st.sampled_from([0.0, 9.0, math.nan]), min_size=1, max_size=60), cuts)
def test_it_stands_as_long_and_as_often_in_pieces(bit: list[float], at: list[int]) -> None:
    told = ticks(np.array(bit))
    np.testing.assert_equal(sticking(told, at), sticking(told, []))


def test_skill_is_what_was_said_less_what_was_confirmed() -> None:
    bit = 10 + np.sin(np.arange(0, 100, 0.02))
    told = skill(ticks(bit), [])
    assert told.ahead_s.tolist() == [0.0, 1.0]
    # The last seconds of `roll` come from the beginning: they are beyond what is confirmed.
    assert told.speed_rad_s == pytest.approx([0.5, 2.0], abs=1e-6)
    assert told.torque_nm == pytest.approx([0.0, 0.0])


@given(
    st.lists(st.floats(-20, 40) | st.just(math.nan), min_size=20, max_size=150),
    st.lists(st.integers(1, 50), min_size=150, max_size=150),
    cuts,
)
def test_skill_is_the_same_in_however_many_pieces(bit: list[float], steps: list[int], at: list[int]) -> None:
    """Naive twin: all that was confirmed in one table, and each prediction held against it."""
    time_ns = np.cumsum(steps[: len(bit)]) * (NS // 50)
    told = replace(
        ticks(np.array(bit)), time_ns=time_ns, confirmed_ns=time_ns - NS, forecast_ns=time_ns + 2 * NS
    )
    found = skill(told, at)
    truth = told["confirmed_bit_speed_rad_s"]
    known = np.isfinite(truth)
    expected = []
    for kind, when in (("now", told.time_ns), ("forecast", told.forecast_ns)):
        said = told[f"{kind}_bit_speed_rad_s"]
        if not known.any():
            continue
        confirmed = told.confirmed_ns[known]
        own = np.isfinite(said) & (when >= confirmed[0]) & (when <= confirmed[-1])
        if own.any():
            missed = said[own] - np.interp(when[own], confirmed, truth[known])
            expected.append(np.sqrt(np.mean(missed**2)))
    assert found.speed_rad_s == pytest.approx(expected, abs=1e-6)


def test_a_clock_set_back_begins_what_is_foretold_anew() -> None:
    bit = 10 + np.sin(np.arange(0, 100, 0.02))
    foretold = Foretold()
    for begin_s in (10_000, 500, 0):
        for piece in pieces(ticks(bit, begin_ns=begin_s * NS), range(0, 5000, 700)):
            foretold.add(piece)
    told = foretold.skill()
    assert told.speed_rad_s == pytest.approx([0.5, 2.0], abs=1e-6)
    assert told.ahead_s.tolist() == [0.0, 1.0]


def test_of_what_is_never_confirmed_nothing_is_kept() -> None:
    foretold = Foretold()
    for begin_s in range(0, 2000, 10):
        unknown = ticks(np.full(500, np.nan), begin_ns=begin_s * NS)
        said = {**unknown.columns, "now_bit_speed_rad_s": np.ones(500)}
        foretold.add(replace(unknown, columns=said))
    held = max(len(missed._asked) for kind in foretold._missed.values() for missed in kind)
    assert held <= 60 * 50
    assert not len(foretold.skill().ahead_s)


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


@given(st.lists(st.lists(st.floats(-1e6, 1e6) | st.just(math.nan), max_size=9), max_size=5))
def test_an_extent_is_that_of_all_that_is_known(told: list[list[float]]) -> None:
    extent = Extent()
    for piece in told:
        extent.add(np.array(piece))
    known = [value for piece in told for value in piece if math.isfinite(value)]
    if known:
        assert (extent.least, extent.greatest) == (min(known), max(known))
        assert extent.mean == pytest.approx(math.fsum(known) / len(known), abs=1e-6)
    else:
        assert all(map(math.isnan, (extent.least, extent.greatest, extent.mean)))
