"""Samples onto the tick's grid: every tick exact, finite and in order, whatever comes in."""

import math
from collections.abc import Iterable, Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.strings import PIPE, rig
from vsensor.errors import InputError
from vsensor.grid import NS
from vsensor.intake import Input, Intake
from vsensor.messages import SENSOR_EVENT, SURFACE_SPEED, SURFACE_TORQUE, Event, Sample
from vsensor.quality import Reason

T, S = SURFACE_TORQUE, SURFACE_SPEED
MS = 1_000_000
BEGUN = 1_700_000_000 * NS
MAX_GAP, RESTART_GAP = 0.25, 2.0
SMALL = rig(PIPE)

Feed = Iterable[tuple[str, Sample]]


def reading(topic: str, time_s: float, value: float = 1.0) -> tuple[str, Sample]:
    return topic, Sample(time_ns=BEGUN + round(time_s * NS), value=value)


def both(times_s: Iterable[float], value: float = 1.0) -> Iterator[tuple[str, Sample]]:
    for time_s in times_s:
        yield reading(T, time_s, value)
        yield reading(S, time_s, value)


def one(topic: str, times_s: Iterable[float], value: float = 1.0) -> Iterator[tuple[str, Sample]]:
    return (reading(topic, time_s, value) for time_s in times_s)


def steps(start_s: float, end_s: float, rate: float = 100.0) -> list[float]:
    return [start_s + k / rate for k in range(round((end_s - start_s) * rate))]


def ticks(feed: Feed, intake: Intake | None = None) -> list[Input]:
    intake = intake or Intake(SMALL)
    return [tick for topic, sample in feed for tick in intake.take(topic, sample)]


def test_samples_on_the_grid_pass_unchanged() -> None:
    values = [math.sin(k) * 1e4 for k in range(50)]
    feed = [reading(topic, k / 100, v) for k, v in enumerate(values) for topic in (T, S)]
    wide = {"speed_limit": 1e5, "speed_noise": 1e4, "torque_noise": 1e4}

    assert ticks(feed, Intake(rig(PIPE, measurement=wide))) == [
        Input(k, BEGUN + k * 10 * MS, v, v, Reason(0)) for k, v in enumerate(values)
    ]


def test_a_tick_comes_as_soon_as_both_channels_reach_it_and_no_sooner() -> None:
    intake = Intake(SMALL)
    assert [len(intake.take(*sample)) for sample in both(steps(0, 0.05))] == [0, 1] * 5


@given(st.floats(0, 0.0099), st.floats(6.0, 700.0), st.floats(6.0, 700.0))
def test_off_the_grid_a_straight_line_is_drawn(shift_s: float, torque_rate: float, speed_rate: float) -> None:
    """A ramp comes out as the same ramp, at any rate of either channel, faster or slower than the tick."""
    wide = Intake(rig(PIPE, measurement={"max_gap": 0.7}))
    torque = [(time_s, T) for time_s in steps(0, 1.0, torque_rate)]
    speed = [(time_s + shift_s, S) for time_s in steps(0, 1.0, speed_rate)]
    given_out = ticks((reading(topic, time_s, time_s) for time_s, topic in sorted(torque + speed)), wide)

    assert len(given_out) >= 50
    for tick in given_out:
        time_s = (tick.time_ns - BEGUN) / NS
        assert tick.motor_torque == pytest.approx(time_s, abs=2e-9)
        assert tick.motor_speed == pytest.approx(time_s, abs=2e-9)
        assert not tick.reasons


@pytest.mark.parametrize("rate", [1.0, 60.0, 100.0, 300.0, 999.0, 5000.0, 29.97])
def test_the_grid_never_drifts(rate: float) -> None:
    wide = {"max_gap": 40 * 86_400, "restart_gap": 50 * 86_400}
    intake = Intake(rig(PIPE, rate=rate, measurement=wide))
    count = 3000
    given_out = ticks(both([0.0, count / rate]), intake)

    whole, hundredths = divmod(round(rate * 100), 100)
    expected = [BEGUN + k * NS * 100 // (whole * 100 + hundredths) for k in range(count)]
    assert [tick.time_ns for tick in given_out[:count]] == expected


def test_late_within_the_buffer_is_put_in_its_place() -> None:
    """Speed is behind, so torque may still be sorted."""
    feed = [reading(T, 0, 0), reading(T, 0.02, 20), reading(T, 0.01, 7), *one(S, [0, 0.01, 0.02])]
    assert [tick.motor_torque for tick in ticks(feed)] == [0, 7, 20]


def test_a_bridged_gap_is_flagged_and_a_small_one_is_not() -> None:
    small, wide = 0.24, 0.26
    for gap, flags in ((small, Reason(0)), (wide, Reason.GAP_BRIDGED)):
        given_out = ticks([*both([0.0]), *both([gap])])
        assert {tick.reasons for tick in given_out[1:-1]} == {flags}


def test_where_a_sample_stands_at_the_edge_of_a_gap_nothing_is_flagged() -> None:
    given_out = ticks([*both([0.0]), *both([1.0]), *both([1.01])])
    assert [given_out[k].reasons for k in (0, 100, 101)] == [0, 0, 0]
    assert {tick.reasons for tick in given_out[1:100]} == {Reason.GAP_BRIDGED}


@pytest.mark.parametrize(
    ("silent", "speaks", "flag"), [(T, S, Reason.STALE_TORQUE), (S, T, Reason.STALE_SPEED)]
)
def test_ticks_go_on_without_one_channel_and_say_so(silent: str, speaks: str, flag: Reason) -> None:
    intake = Intake(SMALL)
    before = ticks(both(steps(0, 1), 3.0), intake)
    alone = ticks(one(speaks, steps(1, 61), 5.0), intake)
    back = ticks(both(steps(61, 62), 7.0), intake)

    everything = [*before, *alone, *back]
    assert [tick.number for tick in everything] == list(range(6200))
    assert intake.restarts == 0
    assert {tick.reasons for tick in alone} == {flag}
    held = {tick.motor_torque if silent == T else tick.motor_speed for tick in alone}
    assert held == {3.0}
    assert back[-1].reasons == 0
    assert (back[-1].motor_torque, back[-1].motor_speed) == (7.0, 7.0)


def test_nothing_comes_out_while_both_are_silent_and_nothing_of_one_alone() -> None:
    intake = Intake(SMALL)
    assert ticks(one(T, steps(0, 10)), intake) == []
    assert len(ticks(one(S, steps(9, 10)), intake)) == 100


@pytest.mark.parametrize("first", [T, S])
def test_whichever_of_two_slow_channels_speaks_first_the_other_is_waited_for(first: str) -> None:
    """One sample past the gap does not mean that the other channel is silent: it may be a moment behind."""
    second = S if first == T else T
    feed = [reading(topic, time_s) for time_s in range(10) for topic in (first, second)]
    assert {tick.reasons for tick in ticks(feed)} == {Reason(0), Reason.GAP_BRIDGED}


def test_a_channel_that_always_comes_half_a_second_later_is_held_at_its_newest() -> None:
    """Its samples are past when they come; the held value must not freeze for that."""
    late_s = 0.5
    feed = [
        pair
        for k, time_s in enumerate(steps(0, 5))
        for pair in (reading(S, time_s), *([reading(T, time_s - late_s, k)] if k >= 50 else []))
    ]
    given_out = ticks(feed)
    assert given_out[-1].reasons == Reason.STALE_TORQUE
    assert given_out[-1].motor_torque > 450


def test_a_channel_that_starts_minutes_after_the_other_starts_the_grid() -> None:
    intake = Intake(SMALL)
    assert ticks(one(T, steps(0, 300)), intake) == []
    given_out = ticks(both(steps(300, 301)), intake)
    assert (given_out[0].number, given_out[0].time_ns) == (0, BEGUN + 300 * NS)
    assert intake.restarts == 0
    assert {tick.reasons for tick in given_out} == {Reason(0)}


@pytest.mark.parametrize("speaks", [T, S])
@pytest.mark.parametrize("once", [False, True], ids=["the other never spoke", "the other fell silent"])
def test_hours_of_one_channel_alone_take_no_more_room(speaks: str, once: bool) -> None:
    intake = Intake(SMALL)
    if once:
        ticks(both([0.0]), intake)
    ticks(one(speaks, steps(0.01, 1000)), intake)
    assert len(intake.channels[speaks].points) <= RESTART_GAP * 100 + 2


def test_a_gap_of_one_channel_alone_before_the_grid_is_still_known_when_the_other_comes() -> None:
    """What is let go of are points that no tick can need: the line to the last one stays."""
    intake = Intake(SMALL)
    ticks([*one(T, steps(0, 100)), reading(T, 101.9, 100.0), reading(T, 101.91, 100.0)], intake)
    given_out = ticks(one(S, steps(101, 101.9)), intake)
    assert given_out[0].time_ns == BEGUN + 101 * NS
    assert {tick.reasons for tick in given_out} == {Reason.GAP_BRIDGED}


def test_a_recorded_command_is_obeyed_again_and_other_events_say_nothing() -> None:
    intake = Intake(rig(PIPE))
    for event in (Event(name="command", text="longer 30 m"), Event(name="stuck", text="longer 30 m")):
        assert intake.take(SENSOR_EVENT, event) == []
    given = ticks(both(steps(0, 0.1)), intake)
    assert [tick.longer_by for tick in given][:2] == [30, 0]


def test_a_recorded_command_that_does_not_fit_the_rig_is_named() -> None:
    with pytest.raises(InputError, match=r"command 'shorter 9 km' does not fit this rig: 9000.0 m are more"):
        Intake(rig(PIPE)).take(SENSOR_EVENT, Event(name="command", text="shorter 9 km"))
