"""Eq. (18) to (25): the paper's numbers, and its transfer functions against the waves they stand for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.estimator import component
from vsensor.paper import distributed, general_line
from vsensor.paper.shaft import SHAFT, TORQUE, Load, load_as_printed, of_length

LOAD = Load(2500.0, 400.0)
TRIP = 2 * component.delay(SHAFT)

loads = st.builds(Load, st.floats(10, 5000), st.floats(1, 2000))
lengths = st.floats(100, 9000)


def test_constants_of_the_papers_shaft() -> None:
    assert component.polar_moment(SHAFT) == pytest.approx(2.903111e-5, rel=1e-6)
    assert component.wave_speed(SHAFT) == pytest.approx(3152.59, rel=1e-5)
    assert component.delay(SHAFT) == pytest.approx(1.268798, rel=1e-6)
    assert pytest.approx(2.537597, rel=1e-6) == TRIP
    assert component.impedance(SHAFT) == pytest.approx(733.009, rel=1e-6)
    assert component.stiffness(SHAFT) == pytest.approx(577.719, rel=1e-6)
    assert component.inertia(SHAFT) == pytest.approx(930.041, rel=1e-6)


def test_the_load_as_printed_counts_the_shaft_twice() -> None:
    assert load_as_printed(SHAFT) == LOAD
    assert load_as_printed(of_length(8000)).inertia == 1570 + 2 * 930


def test_constants_of_the_papers_load() -> None:
    alpha, beta = distributed.load_rule(LOAD, TRIP)
    assert alpha == pytest.approx(0.666300, rel=1e-6)
    assert beta == pytest.approx(8.342504e-4, rel=1e-6)
    assert component.impedance(SHAFT) * beta == pytest.approx(0.611513, rel=1e-6)


def test_the_papers_step_response() -> None:
    answer = distributed.step_response(distributed.difference(SHAFT, LOAD), TORQUE, 200.0)
    top = [9.54968, 4.94540, 12.04852, 11.36935, 14.18914, 14.39444]
    end = [7.24754, 8.49696, 11.70894, 12.77925, 14.29179, 14.99508]
    assert answer.top.value[:6] == pytest.approx(top, rel=1e-6)
    assert answer.end.value[:6] == pytest.approx(end, rel=1e-6)
    assert answer.top.time[:3] == pytest.approx([0, TRIP, 2 * TRIP])
    assert answer.end.time[:2] == pytest.approx([TRIP / 2, 1.5 * TRIP])
    for trace in (answer.top, answer.end):
        assert trace.value[-1] == pytest.approx(17.5, rel=1e-5)


def test_the_coefficients_are_those_of_24_and_25() -> None:
    zeta = component.impedance(SHAFT)
    alpha, beta = distributed.load_rule(LOAD, TRIP)
    model = distributed.difference(SHAFT, LOAD)
    zb = zeta * beta
    assert model.denominator == pytest.approx([1 + zb, 1 - alpha - zb, -alpha])
    assert model.top * zeta == pytest.approx([1 + zb, zb - 1 - alpha, alpha])
    assert model.end == pytest.approx([2 * beta])


@given(lengths, loads, st.sampled_from([1, 2, 4, 16]))
def test_any_number_of_steps_settles_at_the_same_speed(length: float, load: Load, steps: int) -> None:
    model = distributed.difference(of_length(length), load, steps)
    for numerator in (model.top, model.end):
        assert numerator.sum() / model.denominator.sum() == pytest.approx(1 / load.damping, rel=1e-6)


@given(st.floats(0.1, 3.0), st.sampled_from([1, 2, 8]))
def test_they_solve_the_papers_23(omega: float, steps: int) -> None:
    """T₀ and 0 = T₁ − X_L ω₁ from the line's two-port, solved as a 2 by 2 system at a frequency."""
    model = distributed.difference(SHAFT, LOAD, steps)
    s = 0.05 + 1j * omega
    y = np.exp(-s * model.step)
    alpha, beta = distributed.load_rule(LOAD, model.step)
    bound = general_line.shaft(SHAFT).z_form(s) - np.array([[0, 0], [0, (1 - alpha * y) / beta]])
    top, end = np.linalg.solve(bound, np.array([1.0, 0.0]))
    at = np.polynomial.polynomial.polyval
    assert at(y, model.top) / at(y, model.denominator) == pytest.approx(top, rel=1e-6)
    late = np.exp(-s * model.delay)
    assert late * at(y, model.end) / at(y, model.denominator) == pytest.approx(end, rel=1e-6)
    torque = late * at(y, model.end_torque) / at(y, model.denominator)
    assert torque == pytest.approx((1 - alpha * y) / beta * end, rel=1e-6)


@given(st.complex_numbers(min_magnitude=0.05, max_magnitude=0.95))
def test_22_mended_is_the_load_rule(x: complex) -> None:
    """X_L in w, divided by β (w + 1) and not by D_L."""
    alpha, beta = distributed.load_rule(LOAD, TRIP)
    w = (1 + x) / (1 - x)
    assert ((1 + alpha) + w * (1 - alpha)) / (beta * (w + 1)) == pytest.approx((1 - alpha * x) / beta)


@given(lengths, loads, st.sampled_from([1, 2, 6]))
def test_they_are_two_waves_and_a_load(length: float, load: Load, steps: int) -> None:
    """The naive twin: waves in queues, the load stepped as written."""
    shaft = of_length(length)
    model = distributed.difference(shaft, load, steps)
    answer = distributed.step_response(model, 1000.0, 60 * model.step)
    zeta = component.impedance(shaft)
    alpha, beta = distributed.load_rule(load, model.step)
    back = [0.0] * steps  # g that the end has sent, as it comes to the top a round trip after its f
    speed, tops, ends, torques = 0.0, [], [], []
    for _ in range(len(answer.end.time)):
        g = back.pop(0)
        f = 2000.0 - g
        tops.append((f - g) / (2 * zeta))
        # Seen from the end, one delay later: ω = α ω′ + β T with T = f − ζω
        speed = (alpha * speed + beta * f) / (1 + zeta * beta)
        ends.append(speed)
        torques.append(f - zeta * speed)
        back.append(f - 2 * zeta * speed)
    assert answer.top.value == pytest.approx(tops, rel=1e-6, abs=1e-9)
    assert answer.end.value == pytest.approx(ends, rel=1e-6, abs=1e-9)
    assert answer.end_torque.value == pytest.approx(torques, rel=1e-6, abs=1e-6)


def test_as_printed_they_settle_elsewhere() -> None:
    """The printed numerators over the printed denominators, at z = 1."""
    zeta = component.impedance(SHAFT)
    alpha, beta = distributed.load_rule(LOAD, TRIP)
    zb = zeta * beta
    denominator = 1 + (1 - alpha - zb) / (1 + zb) - alpha / (1 + zb)
    printed = distributed.steady_as_printed(SHAFT, LOAD, TORQUE)
    assert printed == pytest.approx(TORQUE * ((1 + zb) + (zb - 1 - alpha) + alpha) / denominator)
    assert printed == pytest.approx(TORQUE * 2 * zb / denominator)
    assert printed > 1000 * TORQUE / LOAD.damping
