"""A string in slips: what it is twisted by nobody measures, and the answers say so."""

import numpy as np
import pytest

from tests.test_estimator import DRILLING
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import CONFIRMED, TOP, TORQUE, TORQUE_STD
from vsensor.estimator.sections import Floats
from vsensor.jit import COMPILED
from vsensor.quality import Quality, Reason, verdict
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import ON_BOTTOM, Plan

if not COMPILED:
    pytest.skip("a minute of a rig: too slow without the compiler", allow_module_level=True)

RATE = DRILLING.loop.rate
STOPS_S, SLIPS_S, LIFTED_S, TURNS_S, SECONDS = 20, 26, 34, 36, 56
STOPPED_ON_BOTTOM = Plan(
    ((0, 0), (5, 8), (STOPS_S, 8), (STOPS_S + 2, 0), (TURNS_S, 0), (TURNS_S + 4, 8)), ON_BOTTOM, 50.0, 0.05
)
"""A drive that stops the string and holds it, twisted by a bit that rests."""


def readings() -> tuple[Floats, Floats, Floats]:
    """Motor torque and speed, and the torque of the bit at the time that is confirmed."""
    source = SimulatedRig(DRILLING, STOPPED_ON_BOTTOM, seed=7)
    rows = np.array([source.sample() for _ in range(round(SECONDS * RATE))])
    time_s, torque, speed, bit_time_s, _, bit_torque = (np.ascontiguousarray(of) for of in rows.T)
    return torque, speed, np.interp(time_s - Estimator(DRILLING).confirmed_delay, bit_time_s, bit_torque)


MOTOR_TORQUE, MOTOR_SPEED, BIT_TORQUE = readings()
LET_OFF = MOTOR_TORQUE.copy()
IN_SLIPS = slice(round(SLIPS_S * RATE), round(LIFTED_S * RATE))
LET_OFF[IN_SLIPS] = DRILLING.measurement.torque_noise * np.random.default_rng(1).normal(
    size=len(LET_OFF[IN_SLIPS])
)
"""The same, but slips hold the string for a while, and the motor's torque is let off."""


def test_a_string_that_its_drive_holds_is_not_in_slips() -> None:
    """Though it is as twisted, and stands as still: the drive tells of it."""
    assert abs(np.mean(MOTOR_TORQUE[IN_SLIPS])) > 1e3, "there is something to be let off"
    assert not (Estimator(DRILLING).run(MOTOR_TORQUE, MOTOR_SPEED).reasons & Reason.IN_SLIPS).any()


def test_one_in_slips_is_known_by_that_it_stands_and_told_with_care_until_it_turns() -> None:
    sensor = Estimator(DRILLING)
    values, reasons = sensor.run(LET_OFF, MOTOR_SPEED)[:2]
    flagged = np.flatnonzero(reasons & Reason.IN_SLIPS) / RATE
    assert SLIPS_S < flagged[0] < SLIPS_S + 1
    assert TURNS_S < flagged[-1] < TURNS_S + 4 + sensor.confirmed_delay
    assert np.diff(flagged) == pytest.approx(1 / RATE)
    assert verdict(int(Reason.IN_SLIPS)) is Quality.UNCERTAIN
    since = slice(round((SLIPS_S + 1) * RATE), round(TURNS_S * RATE))
    missed = np.abs(values[since, CONFIRMED + TORQUE] - BIT_TORQUE[since])
    assert np.mean(missed < 2 * values[since, CONFIRMED + TORQUE_STD]) > 0.9
    before = round((SLIPS_S - 1) * RATE)
    assert (values[since, TOP + TORQUE_STD] > 10 * values[before, TOP + TORQUE_STD]).all()


def test_a_string_that_never_turned_has_nothing_to_be_held() -> None:
    rest = np.random.default_rng(1).normal(size=(2, round(20 * RATE)))
    torque, speed = rest[0] * DRILLING.measurement.torque_noise, rest[1] * DRILLING.measurement.speed_noise
    assert not (Estimator(DRILLING).run(torque, speed).reasons & Reason.IN_SLIPS).any()
