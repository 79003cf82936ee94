"""A string that grows while it runs: its waves stay where they are."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.strings import BIT, COLLAR, DRIVE, PIPE, rig
from vsensor.config import Rig
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import CONFIRMED, NOW, SPEED, TORQUE
from vsensor.estimator.sections import Floats
from vsensor.jit import COMPILED
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

needs_compiler = pytest.mark.skipif(not COMPILED, reason="minutes of a rig: too slow without the compiler")

STAND = 28.5
SHORT = rig(PIPE, COLLAR, rate=50.0, bit=BIT, top_drive=DRIVE)


def longer(of: Rig, metres: float) -> Rig:
    top, *rest = of.string
    return of.model_copy(update={"string": (top.model_copy(update={"length": top.length + metres}), *rest)})


def drilled(of: Rig, scenario: Scenario, seconds: float) -> Floats:
    """Motor torque and speed, time of the bit, its speed; shape (n, 4)."""
    source = SimulatedRig(of, PLANS[scenario], seed=3)
    readings = [source.sample() for _ in range(round(seconds * of.loop.rate))]
    return np.array([(r.motor_torque, r.motor_speed, r.bit_time_s, r.bit_speed) for r in readings])


@needs_compiler
@settings(max_examples=10)
@given(st.floats(-300, 600))
@example(430.0)  # of all lengths the one whose waves take longest to settle, 8 s
@example(-61.0)  # a string so long would have another grid, were it configured so
def test_a_string_that_turns_steadily_goes_on_as_it_did(metres: float) -> None:
    """Steady rotation against a viscous bit: the wall of what is added takes its share, and nothing else."""
    steady = rig(PIPE, COLLAR, rate=50.0, bit={"inertia": 50.0, "viscous_friction": 300.0}, top_drive=DRIVE)
    wall = PIPE.length * PIPE.viscous_friction
    sensor = Estimator(steady)
    sensor.run(np.full(1000, (300 + wall) * 10.0), np.full(1000, 10.0))
    sensor.lengthen(metres)
    more = (300 + wall + metres * PIPE.viscous_friction) * 10.0
    values = sensor.run(np.full(600, more), np.full(600, 10.0)).values
    for kind in (CONFIRMED, NOW):
        np.testing.assert_allclose(values[:, kind + SPEED], 10.0, atol=0.15)
        np.testing.assert_allclose(values[:, kind + TORQUE], 3000.0, atol=150)
    assert values[-1, CONFIRMED + SPEED] == pytest.approx(10.0, abs=0.01)


@needs_compiler
def test_a_stand_added_in_the_middle_of_stick_slip_is_followed() -> None:
    """The record is that of the longer string all along; told of it halfway, the sensor is as good as one
    that knew it from the start."""
    record = drilled(longer(SHORT, 5 * STAND), Scenario.STICK_SLIP, 60)
    told, knew = Estimator(SHORT), Estimator(longer(SHORT, 5 * STAND))
    half = len(record) // 2
    told.run(record[:half, 0], record[:half, 1])
    told.lengthen(5 * STAND)
    assert told.string == knew.string
    assert told.confirmed_delay == pytest.approx(knew.confirmed_delay, abs=0.01)
    knew.run(record[:half, 0], record[:half, 1])
    settled = slice(round(2 * told.warm_up * 50), None)
    errors = []
    for sensor in (told, knew):
        values = sensor.run(record[half:, 0], record[half:, 1]).values[:, CONFIRMED + SPEED]
        when = np.arange(half + 1, len(record) + 1) / 50 - sensor.confirmed_delay
        errors.append((values - np.interp(when, record[:, 2], record[:, 3]))[settled])
        assert np.isfinite(values).all()
    assert np.ptp(record[half:, 3]) > 15
    rms = [float(np.sqrt(np.mean(error**2))) for error in errors]
    assert rms[0] < 1.5 * rms[1] + 0.05


@needs_compiler
def test_what_was_learned_stays_and_the_state_can_be_saved_and_taken_up_again() -> None:
    record = drilled(SHORT, Scenario.STICK_SLIP, 30)
    sensor = Estimator(SHORT)
    sensor.run(record[:, 0], record[:, 1])
    law = sensor.law
    sensor.lengthen(STAND)
    assert sensor.law == law
    saved = sensor.save()
    other = Estimator(longer(SHORT, STAND))
    other.restore(saved)
    one, two = (each.run(record[:200, 0], record[:200, 1]).values for each in (sensor, other))
    assert one.tobytes() == two.tobytes()


@pytest.fixture(scope="module")
def sensor() -> Estimator:
    """One to which nothing is done: whatever is asked of it is refused."""
    return Estimator(SHORT)


@pytest.mark.parametrize("metres", [math.nan, math.inf, -math.inf, 1e9, -2000.0])
def test_a_string_that_none_can_be_is_refused_and_nothing_has_changed(
    sensor: Estimator, metres: float
) -> None:
    before = sensor.save()
    with pytest.raises(ValueError, match=r"is 1500 m long and cannot become \S+ m (longer|shorter)"):
        sensor.lengthen(metres)
    assert all(np.array_equal(array, before[name], equal_nan=True) for name, array in sensor.save().items())


@needs_compiler
def test_before_the_first_tick_it_is_simply_another_string() -> None:
    record = drilled(SHORT, Scenario.SMOOTH, 20)
    grown, knew = Estimator(SHORT), Estimator(longer(SHORT, -STAND))
    grown.lengthen(-STAND)
    one, two = (each.run(record[:, 0], record[:, 1]).values for each in (grown, knew))
    assert one.tobytes() == two.tobytes()


def test_pipe_must_be_left(sensor: Estimator) -> None:
    with pytest.raises(ValueError, match='"pipe" is 1500 m long and cannot become 1500 m shorter'):
        sensor.lengthen(-1500)
