"""A bit that is set down: the law of before is kept until it meets rock, and then in force at once."""

from typing import NamedTuple

import numpy as np
import pytest

from tests.test_estimator import DRILLING
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import NOW, OFF_BOTTOM
from vsensor.estimator.load import law, load_of
from vsensor.estimator.sections import Floats
from vsensor.jit import COMPILED
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import Plan

if not COMPILED:
    pytest.skip("minutes of a rig: too slow without the compiler", allow_module_level=True)

RATE = DRILLING.loop.rate
TURNS = 14.0
LIFTED_S, TOLD_S, WEIGHT_S, ON_S = 40, 54, 58, 61
"""The bit is lifted; told to be on bottom, for little clearance is left; weight comes on; all of it is on."""


class Run(NamedTuple):
    """What came of a record."""

    law: Floats
    """Torque of the law at that speed, at each tick, N·m."""
    miss: Floats
    """Of the bit's speed now, rad/s."""


def run(weight: float, seconds: float) -> Run:
    """Drill, lift the bit, and set it down with such a share of the weight; told, as by depths."""
    load = ((0, 1), (LIFTED_S, 1), (LIFTED_S + 2, 0), (WEIGHT_S, 0), (ON_S, weight))
    source = SimulatedRig(DRILLING, Plan(((0, 0), (5, TURNS)), load, 2.0, 0.05), seed=3)
    rows = np.array([source.sample() for _ in range(round(seconds * RATE))])
    time_s, torque, speed, bit_time_s, bit_speed, _ = rows.T
    sensor, told, laws = Estimator(DRILLING), [], []
    for t, of_torque, of_speed in zip(time_s, torque, speed, strict=True):
        off = OFF_BOTTOM if LIFTED_S + 3 < t < TOLD_S else 0
        told.append(sensor.step(of_torque, of_speed, off)[0][NOW])
        laws.append(law(load_of(sensor.law, 1.0), TURNS))
    return Run(np.array(laws), np.array(told) - np.interp(time_s, bit_time_s, bit_speed))


def over(column: Floats, first_s: float, last_s: float) -> Floats:
    return column[round(first_s * RATE) : round(last_s * RATE)]


def rms(column: Floats) -> float:
    return float(np.sqrt(np.mean(column**2)))


def test_while_it_turns_free_nothing_is_learned_and_what_it_meets_then_is_foretold_at_once() -> None:
    done = run(1.0, ON_S + 17)  # the last travel time of it has no truth
    before = float(np.mean(over(done.law, LIFTED_S - 10, LIFTED_S)))
    assert over(done.law, TOLD_S, ON_S + 15) == pytest.approx(before, rel=0.1)
    assert rms(over(done.miss, ON_S, ON_S + 15)) < 1.5 * rms(over(done.miss, LIFTED_S - 20, LIFTED_S))


def test_less_weight_than_before_is_not_waited_for_without_end() -> None:
    done = run(0.2, ON_S + 50)
    before = float(np.mean(over(done.law, LIFTED_S - 10, LIFTED_S)))
    assert float(np.mean(done.law[-5 * round(RATE) :])) == pytest.approx(0.2 * before, rel=0.25)
