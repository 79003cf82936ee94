"""The general line, eq. (4) to (17): its forms against one another, SciPy, and the program's kernels."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm

from tests.peel import peeled
from tests.strings import COLLAR, PIPE
from vsensor.config import Component
from vsensor.estimator import component
from vsensor.estimator.sections import Line, cut
from vsensor.paper import general_line
from vsensor.paper.general_line import GeneralLine

loss = st.one_of(st.just(0.0), st.floats(1e-3, 2.0))
lines = st.builds(
    GeneralLine,
    length=st.floats(0.1, 3.0),
    inertance=st.floats(0.1, 5.0),
    compliance=st.floats(0.1, 5.0),
    series_loss=loss,
    shunt_loss=loss,
)
frequencies = st.builds(complex, st.floats(0.05, 1.0), st.floats(-6.0, 6.0))


@given(lines, frequencies)
def test_the_w_form_is_the_z_form(line: GeneralLine, s: complex) -> None:
    z_form = line.z_form(s)
    np.testing.assert_allclose(line.w_form(s), z_form, rtol=1e-6, atol=1e-9 * np.abs(z_form).max())


@given(lines, frequencies)
def test_a_line_is_its_differential_equation(line: GeneralLine, s: complex) -> None:
    """d/dx (u, y) = [[0, −(Ls+R)], [−(Cs+G), 0]] (u, y), carried over the length by SciPy's exponential."""
    slope = np.array(
        [[0, -(line.inertance * s + line.series_loss)], [-(line.compliance * s + line.shunt_loss), 0]]
    )
    expected = expm(slope * line.length)
    np.testing.assert_allclose(line.chain(s), expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@given(lines, frequencies)
def test_chain_and_two_port_say_the_same(line: GeneralLine, s: complex) -> None:
    top = np.array([1.0, 0.3 - 0.2j])
    bottom = line.chain(s) @ top
    across = line.z_form(s) @ np.array([top[1], bottom[1]])
    assert across == pytest.approx([top[0], bottom[0]], rel=1e-6)


def test_forms_take_many_frequencies_at_once() -> None:
    line = general_line.shaft(PIPE)
    s = 0.1 + 1j * np.linspace(0.1, 9, 7)
    for form in (line.w_form, line.z_form, line.chain):
        assert form(s).shape == (7, 2, 2)
        np.testing.assert_allclose(form(s)[3], form(s[3]), rtol=1e-13)


def test_a_line_without_distortion_only_weakens_its_waves() -> None:
    """Heaviside's case, R/L = G/C: the paper's real ξ, one delay and one factor for every frequency."""
    line = GeneralLine(length=2.0, inertance=4.0, compliance=9.0, series_loss=0.8, shunt_loss=1.8)
    s = 0.3 + 1j * np.linspace(-5, 5, 11)
    np.testing.assert_allclose(line.impedance(s), math.sqrt(4 / 9))
    np.testing.assert_allclose(
        np.exp(-line.propagation(s)), math.exp(-0.2 * line.delay) * np.exp(-s * line.delay)
    )


def test_without_losses_z_is_one_round_trip() -> None:
    part = Component(length=4000, outer_diameter=0.1682, inner_diameter=0.15)
    line = general_line.shaft(part)
    assert line.delay == pytest.approx(component.delay(part))
    assert line.impedance(1j) == pytest.approx(component.impedance(part))
    s = 0.2 + 0.7j
    assert np.exp(-2 * line.propagation(s)) == pytest.approx(np.exp(-s * 2 * component.delay(part)))


def test_a_hose_loses_what_hagen_and_poiseuille_say() -> None:
    bore, viscosity, length, flow = 0.02, 0.05, 30.0, 1e-4
    line = general_line.hose(length, bore, density=1200.0, sound_speed=1200.0, viscosity=viscosity)
    pressure, through = line.chain(1e-9) @ np.array([1e6, flow])
    assert 1e6 - pressure.real == pytest.approx(
        128 * viscosity * length * flow / (math.pi * bore**4), rel=1e-6
    )
    assert through.real == pytest.approx(flow, rel=1e-6)


def test_a_cable_leaks() -> None:
    line = general_line.cable(
        length=100.0, inductance=1e-6, capacitance=1e-10, resistance=0.0, conductance=1e-6
    )
    _, current = line.chain(1e-9) @ np.array([10.0, 0.0])
    assert current.real == pytest.approx(-10.0 * 100.0 * 1e-6, rel=1e-6)


STEP = 1e-3


def two_port(line: Line, omega: float) -> NDArray[np.complex128]:
    """Peeling's (T, ω) at the bottom for (1, 0) and (0, 1) at the top, as columns, at s = jΩ.

    Peeling is linear and its memory ends, so that cosine and sine are all it takes; and it shows
    the bottom one travel time late.
    """
    steps = 2 * int(line.round_trip.sum()) + 10
    swing = np.exp(1j * omega * STEP * np.arange(steps))
    columns = []
    for torque, speed in ((swing, 0 * swing), (0 * swing, swing)):
        bottom = peeled(line, torque.real, speed.real) + 1j * peeled(line, torque.imag, speed.imag)
        late = omega * STEP * (steps - 1 - int(line.round_trip.sum()) / 2)
        columns.append(bottom[-1] * np.exp(-1j * late))
    return np.array(columns).T


def on_the_grid(part: Component, delay: float) -> Component:
    """The component with a length that takes this many seconds."""
    return part.model_copy(update={"length": delay * component.wave_speed(part), "viscous_friction": 0.0})


@settings(max_examples=15)
@given(st.floats(0.5, 60.0))
def test_peeling_is_the_two_port(omega: float) -> None:
    string = (on_the_grid(PIPE, 120 * STEP), on_the_grid(COLLAR, 30 * STEP))
    pipe, collar = (general_line.shaft(part).chain(1j * omega) for part in string)
    expected = collar @ pipe
    found = two_port(cut(string, STEP, 1e4), omega)
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())


def test_friction_gathered_at_junctions_becomes_the_lines_series_loss() -> None:
    """Drag of the wall is R; sections of half the length bring the kernels four times nearer to the line."""
    omega = 5.0
    rough = on_the_grid(PIPE, 256 * STEP).model_copy(update={"viscous_friction": 0.4})
    expected = general_line.shaft(rough).chain(1j * omega)
    errors = []
    for sections in (4, 8, 16, 32):
        found = two_port(cut((rough,), STEP, rough.length / sections * 1.0001), omega)
        errors.append(np.abs(found / expected - 1).max())
    assert errors[-1] < 1e-3
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    np.testing.assert_allclose(ratios, 4, rtol=0.1)
