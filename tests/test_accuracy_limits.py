"""The least errors that anyone can reach, where they are known in closed form or can be simulated."""

import numpy as np
import pytest

from tests.accuracy import limits
from tests.accuracy.reference import KINDS, cases, least
from tests.accuracy.score import answer
from tests.cases import folder
from tests.strings import BIT, COLLAR, PIPE, rig
from vsensor.config import Bit, TopDrive
from vsensor.estimator import component
from vsensor.estimator.forward import ForwardLine
from vsensor.estimator.sections import cut

ROCK = limits.Rock(500.0, 0.3)


def test_what_is_foretold_on_a_bare_pipe_is_as_in_closed_form() -> None:
    """The bit's response to e^(−t/τ) is (e^(−bt) − e^(−at))/(J(b − a))·(−1), a = 1/τ, b = (D + ζ)/J."""
    bare = rig(
        PIPE.model_copy(update={"viscous_friction": 0.0}), bit={"inertia": 50.0, "viscous_friction": 120.0}
    )
    a, b = 1 / ROCK.time, (120.0 + component.impedance(bare.string[0])) / 50.0
    time = np.linspace(0, 0.9, 100_001)
    of_speed = (np.exp(-b * time) - np.exp(-a * time)) / (50.0 * (b - a)) * -1
    of_torque = np.exp(-a * time) - 120.0 * of_speed
    expected = [
        np.sqrt(2 * ROCK.std**2 / ROCK.time * np.trapezoid(of**2, time)) for of in (of_speed, of_torque)
    ]
    assert limits.foretold(bare, ROCK, 10.0, 0.9) == pytest.approx(expected, rel=3e-3)


def test_what_is_foretold_is_what_the_simulated_string_does() -> None:
    """Until the first wave has come back from the top, where the simulated one has an end."""
    law = {"inertia": 50.0, "viscous_friction": 120.0}
    string = (
        PIPE.model_copy(update={"viscous_friction": 0.1}),
        COLLAR.model_copy(update={"viscous_friction": 0.1}),
    )
    step, horizon = 5e-4, 0.9
    time = step * np.arange(round(horizon / step))
    line = ForwardLine(cut(string, step, 50.0), TopDrive(), Bit(**law), step)
    _, speed, torque = line.run(np.zeros_like(time), np.exp(-time / ROCK.time))
    expected = [np.sqrt(2 * ROCK.std**2 / ROCK.time * step * np.sum(of**2)) for of in (speed, torque)]
    found = limits.foretold(rig(*string, bit=law), ROCK, 10.0, horizon)
    assert found == pytest.approx(expected, rel=0.01)


def test_what_is_confirmed_of_a_bit_at_the_surface_is_as_in_closed_form() -> None:
    """No string between: the speed is measured, and told once more by torque, which the rock disturbs."""
    law = {"inertia": 50.0, "viscous_friction": 120.0}
    near = rig(PIPE.model_copy(update={"length": 1e-6}), bit=law, top_drive={"inertia": 30.0})
    hertz = limits.SPACING_HZ * (np.arange(10_000) + 0.5)
    of_speed, of_torque = 0.015**2 * 0.02, 80.0**2 * 0.02
    turning = np.abs(2j * np.pi * hertz * 80.0 + 120.0) ** 2 / (of_torque + ROCK.spectrum(hertz))
    left = 1 / (1 / of_speed + 1 / limits.BROAD + turning)
    expected = np.sqrt(left.sum() * limits.SPACING_HZ)
    assert limits.confirmed(near, ROCK, 10.0).speed == pytest.approx(expected, rel=1e-4)


def test_no_answer_is_better_than_the_limit() -> None:
    """But for a tenth: one record is not the average of many."""
    (smooth,) = (case for case in cases(folder("VSENSOR_REFERENCE_DATA")) if case.name == "smooth_drilling")
    for kind in KINDS:
        of, best = smooth.score(answer(smooth.right, kind)), least(smooth)[kind]
        assert of.speed > 0.9 * best.speed
        assert of.torque > 0.9 * best.torque


def test_the_law_rises_as_its_slope_says() -> None:
    bit = Bit(**BIT)
    assert limits.slope(bit, 0.0) == pytest.approx(5.0 - 5e3 / 1.5)
    assert limits.slope(bit, 100.0) == pytest.approx(5.0)
