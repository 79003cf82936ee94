"""Sticks foretold, a bit off bottom, a long record: on simulated rigs, whose truth is known."""

import numpy as np
import pytest

from tests.strings import BIT, DRIVE, PIPE, rig
from vsensor.config import Tuning
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import CONFIRMED, OFF_BOTTOM, SPEED, SPEED_STD, STICK, TORQUE, TORQUE_STD
from vsensor.estimator.tune import DELAY, INERTIA, OFFSET
from vsensor.jit import COMPILED
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Plan, Scenario

if not COMPILED:
    pytest.skip("minutes of a rig: too slow without the compiler", allow_module_level=True)

LONG = rig(PIPE.model_copy(update={"length": 2500.0}), bit=BIT, top_drive=DRIVE, rate=50.0)


def test_a_stick_foretold_comes_true() -> None:
    simulated = SimulatedRig(LONG, PLANS[Scenario.STICK_SLIP], seed=3)
    readings = np.array([simulated.sample() for _ in range(60 * 50)])
    told = Estimator(LONG).run(readings[:, 1], readings[:, 2]).values[:, STICK]
    rests = readings[:, 4] == 0
    assert 0.1 < rests.mean() < 0.9
    warned = (told > 0) & (np.arange(len(told)) > 1000) & (np.arange(len(told)) < len(told) - 150)
    assert warned.sum() > 50
    when = readings[warned, 0] + told[warned] + 0.15
    resting = np.interp(when, readings[:, 3], rests.astype(float))
    assert resting.mean() > 0.85


@pytest.mark.parametrize("length", [400.0, 2500.0])
def test_a_stick_is_foretold_as_soon_as_its_stop_is_in_sight(length: float) -> None:
    """Not once it has been seen to last: on a short string that would be after it has come."""
    of = LONG.model_copy(update={"string": (PIPE.model_copy(update={"length": length}),)})
    simulated = SimulatedRig(of, PLANS[Scenario.STICK_SLIP], seed=3)
    readings = np.array([simulated.sample() for _ in range(60 * 50)])
    estimator = Estimator(of)
    told = estimator.run(readings[:, 1], readings[:, 2]).values[1000:, STICK]
    first = told[1:][np.isnan(told[:-1]) & (told[1:] > 0)]
    assert len(first) > 3
    assert np.median(first) > estimator.forecast_horizon - 0.05


def test_smooth_drilling_is_told_of_no_stick() -> None:
    simulated = SimulatedRig(LONG, PLANS[Scenario.SMOOTH], seed=3)
    readings = np.array([simulated.sample() for _ in range(60 * 50)])
    told = Estimator(LONG).run(readings[:, 1], readings[:, 2]).values[:, STICK]
    assert np.isnan(told[1500:]).all()


def test_off_bottom_the_bit_meets_nothing_and_the_law_that_was_learned_is_kept() -> None:
    drilling = SimulatedRig(LONG, PLANS[Scenario.SMOOTH], seed=3)
    estimator = Estimator(LONG)
    readings = np.array([drilling.sample() for _ in range(40 * 50)])
    estimator.run(readings[:, 1], readings[:, 2])
    law = estimator.law
    lifted = SimulatedRig(LONG, PLANS[Scenario.OFF_BOTTOM], seed=3)
    free = np.array([lifted.sample() for _ in range(60 * 50)])
    off = np.full(len(free), OFF_BOTTOM)
    values = estimator.run(free[:, 1], free[:, 2], off).values[1500:]
    assert estimator.law == law
    when = free[1500:, 0] - estimator.confirmed_delay
    error = values[:, CONFIRMED + SPEED] - np.interp(when, free[:, 3], free[:, 4])
    assert np.sqrt(np.mean(error**2)) < 0.15
    assert abs(values[:, CONFIRMED + TORQUE].mean()) < 100


def test_a_torque_that_reads_too_high_is_tared_off_bottom() -> None:
    unsure = LONG.model_copy(update={"tuning": Tuning(friction=0.01, torque_offset=500.0)})
    lifted = SimulatedRig(LONG, PLANS[Scenario.OFF_BOTTOM], seed=3)
    free = np.array([lifted.sample() for _ in range(80 * 50)])
    off = np.full(len(free), OFF_BOTTOM)
    knows, finds = Estimator(LONG), Estimator(unsure)
    exact = knows.run(free[:, 1], free[:, 2], off).values
    found = finds.run(free[:, 1] + 300.0, free[:, 2], off).values
    assert finds.tuning[OFFSET] == pytest.approx(300.0, abs=40)
    assert found[500, CONFIRMED + TORQUE_STD] > 400
    assert finds.tuning_std[OFFSET] < 100
    assert abs(found[3000:, CONFIRMED + TORQUE].mean()) < 60
    truth = np.interp(free[:, 0] - finds.confirmed_delay, free[:, 3], free[:, 4])
    errors = [np.sqrt(np.mean((of[2200:, CONFIRMED + SPEED] - truth[2200:]) ** 2)) for of in (found, exact)]
    assert errors[0] < 1.25 * errors[1]


@pytest.mark.parametrize("length", [30.0, 2500.0])
def test_a_wrong_inertia_is_found_off_bottom_where_the_speed_is_changed(length: float) -> None:
    """From 6 to 12 rad/s within 4 s, as one does to see what the wall takes at either speed."""
    pipe = PIPE.model_copy(update={"length": length, "coulomb_friction": 0.5, "static_friction": 0.5})
    true = rig(pipe, bit={"inertia": 50.0}, top_drive=DRIVE, rate=50.0)
    turned = Plan(((0, 0), (6, 6), (20, 6), (24, 12)), ((0, 0),), damping=4.0, rock_noise=0.0)
    lifted = SimulatedRig(true, turned, seed=3)
    free = np.array([lifted.sample() for _ in range(40 * 50)])
    found = []
    for factor in (1.0, 1.1):
        drive = true.top_drive.model_copy(update={"inertia": factor * true.top_drive.inertia})
        estimator = Estimator(true.model_copy(update={"top_drive": drive}))
        estimator.run(free[:, 1], free[:, 2], np.full(len(free), OFF_BOTTOM))
        found.append(factor * (1 + estimator.tuning[INERTIA]))
    assert found == pytest.approx([1.0, 1.0], abs=0.04)


def test_a_long_record_makes_nobody_too_sure() -> None:
    """Eight minutes of stick-slip: errors stay as large as is stated, and nothing right is corrected."""
    drilling = SimulatedRig(LONG, PLANS[Scenario.STICK_SLIP], seed=3)
    readings = np.array([drilling.sample() for _ in range(8 * 60 * 50)])
    estimator = Estimator(LONG)
    values = estimator.run(readings[:, 1], readings[:, 2]).values[5 * 60 * 50 :]
    when = readings[5 * 60 * 50 :, 0] - estimator.confirmed_delay
    error = values[:, CONFIRMED + SPEED] - np.interp(when, readings[:, 3], readings[:, 4])
    within = np.mean(np.abs(error) <= 2 * values[:, CONFIRMED + SPEED_STD])
    assert 0.90 <= within <= 0.99
    assert np.abs(estimator.tuning[[DELAY, INERTIA]]).max() < 0.002


@pytest.mark.parametrize("wrong", [0.11, 0.176])
def test_a_delay_that_is_wrong_by_a_tenth_makes_nobody_sure_of_another(wrong: float) -> None:
    """So far from the truth shadows see but the side of a valley, and not always the right one."""
    unsure = LONG.model_copy(update={"tuning": Tuning(delay=0.1)})
    pipe = LONG.string[0]
    softer = pipe.model_copy(update={"shear_modulus": pipe.shear_modulus / (1 + wrong) ** 2})
    simulated = SimulatedRig(
        LONG.model_copy(update={"string": (softer,)}), PLANS[Scenario.STICK_SLIP], seed=3
    )
    readings = np.array([simulated.sample() for _ in range(100 * 50)])
    estimator = Estimator(unsure)
    estimator.run(readings[:, 1], readings[:, 2])
    assert abs(wrong - estimator.tuning[DELAY]) < 2 * estimator.tuning_std[DELAY]
