"""Delay and impedance by whose innovations are smallest: led to the truth, and no surer than they may be."""

import math

import numpy as np
import pytest

from tests.strings import BIT, DRIVE, PIPE, rig
from vsensor.config import Rig, TopDrive
from vsensor.config import Tuning as Settings
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import CONFIRMED, SPEED, SPEED_STD
from vsensor.estimator.misfit import BIAS, correct_by_misfit
from vsensor.estimator.sections import Floats
from vsensor.estimator.study import study_string
from vsensor.estimator.tune import BOUND, DELAY, HEARD, IMPEDANCE, Tuning, fresh_tuning
from vsensor.jit import COMPILED
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

OFF = np.array([0.008, 0.03, 0.05])
ALIKE = -0.75
"""Longer delays look like a lower impedance."""
SHARE = 0.3
"""An impedance that is wrong by so much more is as bad as a delay."""
MINUTES = pytest.mark.skipif(not COMPILED, reason="minutes of a rig: too slow without the compiler")
LONG = rig(PIPE.model_copy(update={"length": 2500.0}), bit=BIT, top_drive=DRIVE, rate=50.0)


def misfits(tuning: Tuning, longer: float, stiffer: float, sharp: float) -> None:
    """What five strings miss by if that delay and that impedance are right, beyond what is configured."""
    delay, impedance = float(tuning.value[DELAY]) - longer, float(tuning.value[IMPEDANCE]) - stiffer

    def missed(more_delay: float, more_impedance: float) -> float:
        x, y = delay + more_delay, SHARE * (impedance + more_impedance)
        return 1e4 + sharp * (x * x - 2 * ALIKE * x * y + y * y)

    one, other = float(OFF[DELAY]), float(OFF[IMPEDANCE])
    tuning.misfit[:] = missed(0, 0), missed(one, 0), missed(-one, 0), missed(0, other), missed(0, -other)
    tuning.crossed[:] = -4 * one * other * sharp * ALIKE * SHARE


def told(longer: float, stiffer: float, sharp: float, rounds: int = 12) -> list[float]:
    """What delay and impedance are corrected to, each time after misfits about what is right."""
    tuning = fresh_tuning(Settings(), 1.0)
    for _ in range(rounds):
        misfits(tuning, longer, stiffer, sharp)
        correct_by_misfit(tuning, OFF, True)
    return [float(value) for value in tuning.value[HEARD]]


@pytest.mark.parametrize(
    ("longer", "stiffer"), [(0.015, 0.0), (-0.015, 0.0), (0.0, 0.05), (0.0, -0.05), (-0.015, 0.05)]
)
def test_misfits_lead_to_the_truth_and_what_is_right_stays_so(longer: float, stiffer: float) -> None:
    assert told(longer, stiffer, sharp=1e9) == pytest.approx([longer, stiffer], abs=3e-4)


def test_a_wrong_impedance_alone_is_not_laid_to_the_delay_for_a_while() -> None:
    tuning = fresh_tuning(Settings(), 1.0)
    misfits(tuning, 0.0, 0.025, sharp=1e9)
    assert correct_by_misfit(tuning, OFF, True)
    assert tuning.value[HEARD] == pytest.approx([0.0, 0.025], abs=3e-4)


def test_what_is_right_stays_and_what_is_unsure_stays() -> None:
    assert told(0.0, 0.0, sharp=1e9) == [0.0, 0.0]
    assert told(0.01, 0.0, sharp=1.0) == [0.0, 0.0]
    assert told(0.0, 0.03, sharp=1.0) == [0.0, 0.0]


def test_no_correction_goes_beyond_three_deviations_and_none_is_made_when_switched_off() -> None:
    assert told(1.0, 0.0, sharp=1e9, rounds=60)[DELAY] == pytest.approx(BOUND * 0.01)
    assert told(0.0, 1.0, sharp=1e9, rounds=60)[IMPEDANCE] == pytest.approx(BOUND * 0.02)
    tuning = fresh_tuning(Settings(), 1.0)
    misfits(tuning, 0.015, 0.05, sharp=1e9)
    assert not correct_by_misfit(tuning, OFF, False)
    assert (tuning.value == 0).all()


def test_however_long_the_record_they_are_told_no_better_than_by_what_else_looks_like_them() -> None:
    tuning = fresh_tuning(Settings(), 1.0)
    misfits(tuning, 0.0, 0.0, sharp=1e12)
    correct_by_misfit(tuning, OFF, True)
    assert np.sqrt(tuning.variance[HEARD]) == pytest.approx(BIAS, rel=0.01)


def test_what_the_record_holds_for_likelier_but_is_not_taken_up_stays_in_doubt() -> None:
    """Switched off, a delay that is wrong is known to be, and the deviation says so.

    With all that was configured where a shadow is nearer: the valley's floor was not seen.
    """
    for wrong, besides in ((0.4 * OFF[DELAY], BIAS[DELAY]), (0.015, Settings().delay)):
        tuning = fresh_tuning(Settings(), 1.0)
        misfits(tuning, wrong, 0.0, sharp=1e9)
        correct_by_misfit(tuning, OFF, False)
        assert tuning.variance[DELAY] ** 0.5 == pytest.approx(math.hypot(wrong, besides), rel=0.05)


def test_what_is_known_exactly_is_never_corrected() -> None:
    tuning = fresh_tuning(Settings(), 1.0)
    tuning.prior[DELAY] = 0.0
    misfits(tuning, 0.01, 0.04, sharp=1e9)
    assert correct_by_misfit(tuning, OFF, True)
    assert tuning.value[DELAY] == tuning.variance[DELAY] == 0
    assert tuning.value[IMPEDANCE] > 0


def test_no_string_has_its_own_misses_excused() -> None:
    """What one misses when it has long missed weighs as much as what another does when that one has."""
    estimator = Estimator(LONG)
    model, state = estimator._model, estimator._state
    model = model._replace(rate=1e9)  # nothing is forgotten meanwhile
    for astray in range(5):
        state.innovation[:], state.surprise[:] = 0.01, 1.0
        state.innovation[astray], state.surprise[astray] = 0.1, 100.0
        getattr(study_string, "py_func", study_string)(model, state)
    assert state.tuning.misfit == pytest.approx(np.full(5, state.tuning.misfit[0]))


def of_impedance(right: Rig, share: float) -> Rig:
    """The rig with pipe of another wall, whose polar moment is larger by a share."""
    pipe = right.string[0]
    polar = (1 + share) * (pipe.outer_diameter**4 - pipe.inner_diameter**4)
    bore = (pipe.outer_diameter**4 - polar) ** 0.25
    return right.model_copy(update={"string": (pipe.model_copy(update={"inner_diameter": bore}),)})


def blind(of: Rig) -> Rig:
    """The rig whose impedance is held to be beyond doubt."""
    return of.model_copy(update={"tuning": Settings(enabled=False, impedance=1e-6)})


def stick_slip(true: Rig, seconds: float) -> Floats:
    """Readings of the rig in stick-slip and of its bit, as `simulate.rig.Reading`."""
    simulated = SimulatedRig(true, PLANS[Scenario.STICK_SLIP], seed=3)
    return np.array([simulated.sample() for _ in range(round(seconds * true.loop.rate))])


def runs(of: Rig, readings: Floats) -> tuple[Estimator, float, float]:
    """The estimator after all readings, rms error of its last half minute, share within two deviations."""
    estimator = Estimator(of)
    values = estimator.run(readings[:, 1], readings[:, 2]).values
    when = readings[:, 0] - estimator.confirmed_delay
    error = values[:, CONFIRMED + SPEED] - np.interp(when, readings[:, 3], readings[:, 4])
    within = np.abs(error) <= 2 * values[:, CONFIRMED + SPEED_STD]
    return estimator, float(np.sqrt(np.mean(error[-1500:] ** 2))), float(np.mean(within[500:]))


@MINUTES
@pytest.mark.parametrize("worn", [0.04, -0.04])
def test_pipe_whose_wall_is_not_as_told_is_found_out_by_its_stick_slip(worn: float) -> None:
    readings = stick_slip(LONG, 300.0)
    wrong = of_impedance(LONG, worn)
    estimator, found, _ = runs(wrong, readings)
    _, misled, _ = runs(blind(wrong), readings)
    left = 1 / (1 + worn) - 1 - estimator.tuning[IMPEDANCE]
    assert abs(left) < 2 * estimator.tuning_std[IMPEDANCE]
    assert abs(left) < 0.02
    assert abs(estimator.tuning[DELAY]) < 0.01
    assert found < 0.6 * misled


@MINUTES
@pytest.mark.parametrize("worn", [0.05, -0.05])
def test_until_it_is_found_out_the_deviations_hold_what_it_costs(worn: float) -> None:
    light = LONG.model_copy(update={"top_drive": TopDrive(inertia=500.0)})
    readings = stick_slip(light, 55.0)
    wrong = of_impedance(light, worn)
    estimator, _, honest = runs(wrong, readings)
    _, _, deceived = runs(blind(wrong), readings)
    assert (estimator.tuning == 0).all()
    assert deceived < 0.9 < honest
