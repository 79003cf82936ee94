"""A sample whose value leaps: the next bears it out, or it was a stray, refused as if it had been lost."""

import numpy as np
import pytest

from tests.strings import PIPE, rig
from tests.test_intake import SMALL, S, T, both, one, reading, steps, ticks
from tests.test_intake_ahead import refused
from vsensor.intake import Input, Intake
from vsensor.messages import Sample
from vsensor.quality import Reason

LEVEL = {T: 8e3, S: 12.0}
NOISE = {T: SMALL.measurement.torque_noise, S: SMALL.measurement.speed_noise}
FAR = {T: 3e4, S: 25.0}
DOUBTLESS = rig(PIPE, measurement={"torque_noise": 1e5, "speed_noise": 100.0})
"""Of so much noise no value leaps."""
Readings = list[tuple[str, Sample]]


def noisy(rate: float = 100.0, count: int = 300, seed: int = 1, order: tuple[str, str] = (T, S)) -> Readings:
    """Both channels in turn at their levels, with the noise of the configuration."""
    draws = np.random.default_rng(seed).normal(size=(count, 2)).tolist()
    return [
        reading(topic, k / rate, LEVEL[topic] + NOISE[topic] * draw)
        for k, row in enumerate(draws)
        for topic, draw in zip(order, row, strict=True)
    ]


def wild(fed: Readings, at: int, value: float) -> Readings:
    """The same with another value at one place."""
    topic, sample = fed[at]
    return [*fed[:at], (topic, Sample(time_ns=sample.time_ns, value=value)), *fed[at + 1 :]]


def place(topic: str, k: int) -> int:
    return 2 * k + (topic == S)


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("topic", [T, S])
@pytest.mark.parametrize("rate", [5.0, 100.0, 1000.0])
def test_one_wild_value_is_as_a_sample_that_was_lost(rate: float, topic: str, sign: int) -> None:
    fed, at = noisy(rate), place(topic, 150)
    intake = Intake(SMALL)
    assert ticks(wild(fed, at, sign * FAR[topic]), intake) == ticks(fed[:at] + fed[at + 1 :])
    assert refused(intake, topic) == {"strays": 1}


@pytest.mark.parametrize("order", [(T, S), (S, T)])
@pytest.mark.parametrize("rate", [1.0, 5.0, 20.0, 100.0, 1000.0])
def test_a_true_step_loses_nothing_and_costs_one_samples_time(rate: float, order: tuple[str, str]) -> None:
    fed = noisy(rate, order=order)
    for at in range(100, 200):
        fed[at][1].value *= 1.5
    intake, doubtless = Intake(SMALL), Intake(DOUBTLESS)
    late = 0
    given: list[Input] = []
    expected: list[Input] = []
    for topic, sample in fed:
        given += intake.take(topic, sample)
        expected += doubtless.take(topic, sample)
        late = max(late, len(expected) - len(given))
    assert given == expected
    assert not any(tick.reasons & ~Reason.GAP_BRIDGED for tick in given)
    assert [refused(intake, topic) for topic in (T, S)] == [{}, {}]
    assert 0 < late <= max(2, 1 + 200 / rate)


@pytest.mark.parametrize(("behind", "books"), [(5.1e3, {}), (4.9e3, {"strays": 1})])
def test_the_next_bears_out_what_it_is_nearer_to(behind: float, books: dict[str, int]) -> None:
    values = [0.0] * 100 + [1e4] + [behind] * 100
    intake = Intake(SMALL)
    told = ticks(
        [pair for k, v in enumerate(values) for pair in (reading(T, k / 100, v), reading(S, k / 100))], intake
    )
    assert (1e4 in [tick.motor_torque for tick in told]) == (not books)
    assert told[-1].motor_torque == behind
    assert refused(intake, T) == books


def test_a_ramp_is_followed_however_steep() -> None:
    values = [0.0] * 100 + [5.0 * k for k in range(10)] + [50.0] * 100
    intake = Intake(SMALL)
    told = ticks([(topic, s) for k, v in enumerate(values) for topic, s in both([k / 100], v)], intake)
    assert [tick.motor_speed for tick in told] == values
    assert refused(intake, S) == {}


def test_two_wild_values_in_a_row_are_refused_where_they_do_not_agree() -> None:
    fed, at = noisy(), place(T, 150)
    intake = Intake(SMALL)
    told = ticks(wild(wild(fed, at, 3e4), at + 2, -3e4), intake)
    assert told == ticks([each for k, each in enumerate(fed) if k not in (at, at + 2)])
    assert refused(intake, T) == {"strays": 2}


def test_a_wild_value_right_behind_a_step_is_refused_and_the_step_is_not() -> None:
    fed = noisy()
    for at in range(place(T, 150), len(fed), 2):
        fed[at][1].value += 5e3
    intake, at = Intake(SMALL), place(T, 151)
    assert ticks(wild(fed, at, 3e4), intake) == ticks(fed[:at] + fed[at + 1 :])
    assert refused(intake, T) == {"strays": 1}


@pytest.mark.parametrize("second", [150, 151, 152])
def test_a_step_whose_samples_come_in_the_wrong_order_loses_nothing(second: int) -> None:
    """Speed is behind, so that torque may still be sorted."""
    torque = [each for each in noisy() if each[0] == T]
    speed = [each for each in noisy() if each[0] == S]
    for _, sample in torque[151:]:
        sample.value += 5e3
    swapped = torque[:second] + torque[second : second + 2][::-1] + torque[second + 2 :]
    intake = Intake(SMALL)
    assert ticks([*swapped[:200], *speed[:200]], intake) == ticks([*torque[:200], *speed[:200]])
    assert refused(intake, T) == {}


@pytest.mark.parametrize("late", [1, 2, 5])
def test_a_wild_value_is_refused_wherever_it_comes_in_time_for_its_tick(late: int) -> None:
    torque = [each for each in noisy() if each[0] == T]
    speed = [each for each in noisy() if each[0] == S]
    stray = reading(T, 1.5, -3e4)
    without = torque[:150] + torque[151:]
    intake = Intake(SMALL)
    fed = [*without[: 150 + late], stray, *without[150 + late : 200]]
    assert ticks([*fed, *speed[:200]], intake) == ticks([*without[:200], *speed[:200]])
    assert refused(intake, T) == {"strays": 1}


@pytest.mark.parametrize("silent_s", [0.1, 1.0, 1.9, 5.0, 60.0])
@pytest.mark.parametrize("step", [True, False])
def test_what_waits_when_its_channel_falls_silent_is_settled_by_the_first_behind(
    silent_s: float, step: bool
) -> None:
    intake = Intake(SMALL)
    ticks([*both(steps(0, 5), 8.0), reading(S, 5, 20.0), reading(T, 5, 8.0)], intake)
    alone = ticks(one(T, steps(5.01, 5 + silent_s), 8.0), intake)
    assert {tick.motor_speed for tick in alone} <= {8.0}
    after = 20.0 if step else 8.0
    back = ticks(
        [pair for time_s in steps(5 + silent_s, 6 + silent_s) for pair in both([time_s], after)], intake
    )
    assert back[-1].motor_speed == after
    assert back[-1].reasons == 0
    assert refused(intake, S) == ({} if step else {"strays": 1})


def test_behind_a_silence_the_next_sample_settles_both_time_and_value() -> None:
    for back, books in ((20.0, {}), (8.1, {"strays": 1})):
        intake = Intake(SMALL)
        ticks([*both(steps(0, 5), 8.0), *one(T, steps(5, 6), 8.0)], intake)
        told = ticks([reading(S, 6, 20.0), *both(steps(6.01, 8), back)], intake)
        assert told[-1].motor_speed == back
        assert refused(intake, S) == books


def test_the_last_of_a_record_that_leaps_is_left_waiting() -> None:
    intake = Intake(SMALL)
    assert len(ticks([*both(steps(0, 1)), reading(T, 1), reading(S, 1, 20.0)], intake)) == 100
    assert refused(intake, S) == {}
    assert intake.channels[S].waiting is not None


def test_one_that_leaps_and_waits_when_all_begins_anew_is_a_stray() -> None:
    intake = Intake(SMALL)
    ticks([*both(steps(0, 1)), reading(S, 1, 20.0), *both(steps(100, 101))], intake)
    assert intake.restarts == 1
    assert refused(intake, S)["strays"] == 1
    assert intake.channels[S].waiting is None


def test_a_wild_first_sample_is_left_behind_by_the_third() -> None:
    intake = Intake(SMALL)
    told = ticks([reading(T, 0, 3e4), reading(S, 0), *both(steps(0.01, 1))], intake)
    assert [tick.motor_torque for tick in told] == [3e4] + [1.0] * 99
    assert refused(intake, T) == {}
