"""Channels noisier than told, or read in coarse steps: seen for what they are, and doubted."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.rigs import RATE, SHORT
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.figures import STUCK_SPEED
from vsensor.estimator.kernel import CONFIRMED
from vsensor.estimator.noise import CHANGES, SHARES
from vsensor.estimator.sections import Floats
from vsensor.jit import COMPILED
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

pytestmark = pytest.mark.skipif(not COMPILED, reason="minutes of a rig: too slow without the compiler")

TOLD = SHORT.measurement.torque_noise, SHORT.measurement.speed_noise
RPM = np.pi / 30


@pytest.fixture(scope="module")
def record() -> Floats:
    """Motor torque and speed, and the bit's speed at its own time, 60 s of stick-slip, shape (4, n)."""
    source = SimulatedRig(SHORT, PLANS[Scenario.STICK_SLIP], seed=1)
    readings = [source.sample() for _ in range(60 * RATE)]
    return np.array([(r.motor_torque, r.motor_speed, r.bit_time_s, r.bit_speed) for r in readings]).T


def read_in(step: float, values: Floats) -> Floats:
    return np.round(values / step) * step if step else values


def judged(torque: Floats, speed: Floats) -> tuple[Floats, float]:
    sensor = Estimator(SHORT)
    sensor.run(torque, speed)
    return sensor.coarse_steps, float(sensor.noisier**2)


@pytest.mark.parametrize(("torque_step", "speed_step"), [(0.0, RPM), (1000.0, 0.0), (1000.0, RPM)])
def test_the_steps_of_a_reading_are_found_and_what_they_cost(
    record: Floats, torque_step: float, speed_step: float
) -> None:
    steps, squared = judged(read_in(torque_step, record[0]), read_in(speed_step, record[1]))
    for found, step in zip(steps, (torque_step, speed_step), strict=True):
        assert found == pytest.approx(step)
    counts = np.multiply(SHARES, (torque_step, speed_step)) / TOLD
    assert squared == pytest.approx(counts.max() ** 2)


@pytest.mark.parametrize("digits", [None, 3, 2])
def test_a_reading_that_is_finer_than_its_noise_is_taken_as_told(record: Floats, digits: int | None) -> None:
    """Continuous, or printed with a few decimals: 0.01 rad/s where the noise is 0.015."""
    torque, speed = (values if digits is None else np.round(values, digits) for values in record[:2])
    steps, squared = judged(torque, speed)
    assert squared == 1.0
    assert (steps == 0).all()


@settings(max_examples=20)
@given(st.floats(0.03, 1.0), st.integers(0, 2**32 - 1))
def test_whatever_the_step_and_the_changes_it_is_found(step: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    whole = random.integers(40, 60, 5 * RATE).astype(float)
    found, _ = judged(random.normal(5e3, 80.0, len(whole)), step * whole)
    assert len(np.flatnonzero(np.diff(whole))) > CHANGES
    assert found[1] == pytest.approx(step)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_noise_has_no_steps(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = 5 * RATE
    steps, _ = judged(random.normal(5e3, 800.0, count), random.normal(10.0, 0.15, count))
    assert (steps == 0).all()


def test_a_speed_in_whole_revolutions_does_not_pass_for_a_restless_rock(record: Floats) -> None:
    """The error stays a fraction of what it is where the noise is believed, and within what is stated."""
    torque, speed, times, truth = record
    sensor = Estimator(SHORT)
    told = sensor.run(torque, read_in(RPM, speed)).values
    at = np.arange(1, len(told) + 1) / RATE - sensor.confirmed_delay
    begun = round(20 * RATE)
    true = np.interp(at[begun:], times, truth)
    error = told[begun:, CONFIRMED] - true
    assert np.mean(np.abs(error) <= 2 * told[begun:, CONFIRMED + 1]) >= 0.9
    assert np.sqrt(np.mean(error**2)) < 0.03 * np.ptp(true)
    assert sensor.rock_std < 600.0
    assert true.min() < STUCK_SPEED


@pytest.mark.parametrize("times", [1.0, 2.0, 4.0])
def test_how_much_noisier_the_channels_are_than_told_is_found(record: Floats, times: float) -> None:
    """And the sensor is then as good as one that was told."""
    torque, speed, when, truth = record
    noise = SHORT.measurement.model_copy(
        update={"torque_noise": TOLD[0] / times, "speed_noise": TOLD[1] / times}
    )
    told_less, told = Estimator(SHORT.model_copy(update={"measurement": noise})), Estimator(SHORT)
    errors = []
    for sensor in (told_less, told):
        values = sensor.run(torque, speed).values
        begun = round(30 * RATE)
        at = np.arange(begun + 1, len(values) + 1) / RATE - sensor.confirmed_delay
        errors.append(np.sqrt(np.mean((values[begun:, CONFIRMED] - np.interp(at, when, truth)) ** 2)))
    assert told_less.noisier == pytest.approx(times, rel=0.1)
    assert told.noisier == 1.0
    assert errors[0] == pytest.approx(errors[1], rel=0.1)


def on_lines(values: Floats, apart: float, begun: float = 0.0) -> Floats:
    """Read once in so many ticks, with straight lines from one reading to the next."""
    ticks = np.arange(len(values), dtype=float)
    read = np.arange(begun, len(values), apart)
    told: Floats = np.interp(ticks, read, np.interp(read, ticks, values))
    return told


@pytest.mark.parametrize(
    ("apart", "begun"), [(2, 0), (3, 0), (10, 0), (10, 0.3), (4, 0.5), (8.3, 0.0), (20, 0)]
)
def test_how_many_ticks_a_reading_of_speed_lasts_is_found(record: Floats, apart: float, begun: float) -> None:
    sensor = Estimator(SHORT)
    sensor.run(record[0], on_lines(record[1], apart, begun))
    assert sensor.ticks_a_reading == pytest.approx(apart, rel=0.1)
    assert sensor.noisier**2 == pytest.approx(sensor.ticks_a_reading)
    sensor.run(*record[:2])
    assert sensor.ticks_a_reading == 1.0


def test_readings_lost_at_random_are_counted_as_lost(record: Floats) -> None:
    """A ragged half of them: two ticks to a reading, up to twice of which may be held to be."""
    ticks = np.arange(record.shape[1], dtype=float)
    read = np.flatnonzero(np.random.default_rng(2).random(len(ticks)) < 0.6)
    sensor = Estimator(SHORT)
    sensor.run(record[0], np.interp(ticks, read, record[1, read]))
    assert 1.5 < sensor.ticks_a_reading < 3.4


def test_a_string_that_stands_between_turns_is_read_as_often_as_before(record: Floats) -> None:
    """The speed of a drive that holds is the same to the last digit, for as long as it holds."""
    sensor, stands = Estimator(SHORT), (np.full(20 * RATE, 1e3), np.zeros(20 * RATE))
    turns = record[:2, 4 * RATE : 5 * RATE]
    for torque, speed in (stands, turns, stands, turns):
        sensor.run(torque, speed)
        assert sensor.ticks_a_reading == 1.0


@pytest.mark.parametrize("noise", [0.0, 1e-6, 0.015])
def test_what_swings_smoothly_is_no_line(noise: float) -> None:
    seconds = np.arange(30 * RATE) / RATE
    speed = 10 + 0.1 * np.sin(seconds) + noise * np.random.default_rng(1).normal(size=len(seconds))
    sensor = Estimator(SHORT)
    sensor.run(np.full_like(speed, 5e3), speed)
    assert sensor.ticks_a_reading == 1.0


def test_gains_follow_at_once_where_channels_are_found_to_be_noisier(record: Floats) -> None:
    """The rock is as restless as before: beside channels so noisy it is calm. Till it stops being at rest the
    bit tells nothing of it, and the gains would be those of a rock that shakes the whole string."""
    sensor = Estimator(SHORT)
    at_rest = np.linspace(0.3, 0.9, 2 * RATE) + np.random.default_rng(1).normal(0, 0.015, 2 * RATE)
    before = sensor.bandwidth
    sensor.run(np.full(2 * RATE, 1e3), on_lines(at_rest, 10))
    assert sensor.ticks_a_reading == pytest.approx(10, rel=0.1)
    assert sensor.bandwidth < before


def test_what_is_known_of_the_steps_outlives_a_gap_and_is_saved(record: Floats) -> None:
    sensor, other = Estimator(SHORT), Estimator(SHORT)
    sensor.run(record[0], read_in(RPM, record[1]))
    sensor.restart()
    assert sensor.coarse_steps[1] == pytest.approx(RPM)
    other.begin_with(sensor.learned())
    np.testing.assert_array_equal(other.coarse_steps, sensor.coarse_steps)
