"""The lumped string, eq. (1) to (3): one system said in two ways, and what it must do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from vsensor.paper import lumped
from vsensor.paper.lumped import Lumped
from vsensor.paper.shaft import SHAFT, TORQUE, of_length

positive = st.floats(1.0, 5e3)
strings = st.builds(Lumped, positive, positive, positive, positive, positive, positive)


@given(strings, st.floats(0.01, 100.0))
def test_state_space_and_transfer_functions_are_one_system(model: Lumped, frequency: float) -> None:
    """By their answers to a swing: SciPy's way to the coefficients loses digits where inertias are small."""
    a, b, c = lumped.state_space(model)
    told = lumped.transfer_functions(model)
    s = 1j * frequency
    answers = c @ np.linalg.solve(s * np.eye(3) - a, b)
    for found, numerator in ((answers[0, 0], told.top), (answers[1, 0], told.end)):
        assert found == pytest.approx(np.polyval(numerator, s) / np.polyval(told.denominator, s), rel=1e-7)


def test_the_step_is_that_of_the_transfer_functions() -> None:
    model = lumped.of_shaft(SHAFT)
    time = np.linspace(0, 40, 2001)
    answer = lumped.step_response(model, TORQUE, time)
    told = lumped.transfer_functions(model)
    for trace, numerator in ((answer.top, told.top), (answer.end, told.end)):
        _, expected = signal.step((TORQUE * numerator, told.denominator), T=time)
        np.testing.assert_allclose(trace.value, expected, rtol=1e-9, atol=1e-9)


def test_the_papers_string_rises_to_its_steady_speed_without_overshoot() -> None:
    answer = lumped.step_response(Lumped(930.0, 1570.0, 580.0), TORQUE, np.linspace(0, 100, 10001))
    for trace in (answer.top, answer.end):
        assert trace.value.max() <= 17.5
        assert trace.value[-1] == pytest.approx(17.5, rel=1e-5)


def test_the_shaft_carries_what_turns_the_bit() -> None:
    """The mended second line of (1): the shaft's torque is (J_b s + C_b) ω_b."""
    model = lumped.of_shaft(SHAFT)
    time = np.linspace(0, 30, 30_001)
    answer = lumped.step_response(model, TORQUE, time)
    turning = model.J_b * np.gradient(answer.end.value, time) + model.C_b * answer.end.value
    np.testing.assert_allclose(answer.end_torque.value[1:-1], turning[1:-1], atol=0.01)


def test_the_pipe_of_another_length_is_as_much_heavier_and_softer() -> None:
    model = lumped.of_shaft(of_length(8000))
    assert (model.J_r, model.J_b, model.k) == (1860.0, 1570.0, 290.0)
