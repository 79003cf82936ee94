"""Natural frequencies of a lossless string: known strings, and laws that hold for every string."""

import math
from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.config import Component
from vsensor.estimator import component
from vsensor.estimator.modes import Floats, torsional_modes

DENSITY = 7850.0
WAVE_SPEED = 2787.6


def bar(impedance: float, length: float) -> Component:
    """A solid bar of a given impedance, at one wave speed for all."""
    modulus = WAVE_SPEED**2 * DENSITY
    moment = impedance / math.sqrt(DENSITY * modulus)
    diameter = (32 * moment / math.pi) ** 0.25
    return Component(
        length=length, outer_diameter=diameter, inner_diameter=0, shear_modulus=modulus, density=DENSITY
    )


BODY, JOINT = (9.0, 0.127, 0.1086), (0.5, 0.168, 0.083)
"""Length, outer and inner diameter of a joint of drill pipe, and of its pin and box."""


def test_pipe_with_tool_joints_rings_as_its_joints_one_by_one() -> None:
    part = (
        Component(length=length, outer_diameter=outer, inner_diameter=inner)
        for length, outer, inner in (BODY, JOINT)
    )
    one_by_one = torsional_modes((*part,) * 200, 0.0, 8)
    told = Component(
        length=200 * (BODY[0] + JOINT[0]),
        outer_diameter=BODY[1],
        inner_diameter=BODY[2],
        tool_joint_diameter=JOINT[1],
        tool_joint_bore=JOINT[2],
        tool_joint_length=JOINT[0],
        joint_length=BODY[0] + JOINT[0],
    )
    assert torsional_modes((told,), 0.0, 8) == pytest.approx(one_by_one, rel=2e-3)
    of_body = torsional_modes((told.model_copy(update={"tool_joint_length": 0.0}),), 0.0, 8)
    assert np.all(of_body > 1.05 * one_by_one)


strings = st.lists(st.builds(bar, st.floats(50, 5000), st.floats(5, 3000)), min_size=1, max_size=6)
inertias = st.one_of(st.just(0.0), st.floats(1e-3, 1e4))
tops: st.SearchStrategy[Literal["held", "free"]] = st.sampled_from(["held", "free"])


def test_pipe_and_collars_ring_as_published() -> None:
    string = (bar(498.26, 2270), bar(1858.65, 230))
    assert torsional_modes(string, 0, 3) == pytest.approx([0.2261, 0.7300, 1.2918], abs=5e-5)


@pytest.mark.parametrize("pieces", [1, 7])
def test_a_uniform_shaft_rings_at_odd_quarters_held_and_at_halves_free(pieces: int) -> None:
    length = 2500.0
    string = [bar(500, length / pieces)] * pieces
    n = np.arange(1, 9)
    assert torsional_modes(string, 0, 8) == pytest.approx((2 * n - 1) * WAVE_SPEED / (4 * length))
    assert torsional_modes(string, 0, 8, top="free") == pytest.approx(n * WAVE_SPEED / (2 * length))


def test_a_heavy_bit_on_a_light_string_is_a_torsion_pendulum() -> None:
    part = bar(500, 100)
    heavy = 1e4 * component.inertia(part)
    pendulum = math.sqrt(component.stiffness(part) / heavy) / (2 * math.pi)
    assert torsional_modes([part], heavy, 1)[0] == pytest.approx(pendulum, rel=1e-4)


@given(strings, inertias, tops)
def test_modes_ascend_and_none_is_missed(
    string: list[Component], inertia: float, top: Literal["held", "free"]
) -> None:
    modes = torsional_modes(string, inertia, 12, top=top)
    assert np.all(modes > 0)
    assert np.all(np.diff(modes) > 0)
    assert modes == pytest.approx(scanned(string, inertia, top, modes[-1] * 1.0001), abs=modes[-1] / 1e5)


@given(strings, inertias, st.floats(0.1, 10), tops)
def test_a_string_twice_as_long_rings_half_as_fast(
    string: list[Component], inertia: float, times: float, top: Literal["held", "free"]
) -> None:
    longer = [part.model_copy(update={"length": part.length * times}) for part in string]
    modes = torsional_modes(string, inertia, 5, top=top)
    assert torsional_modes(longer, inertia * times, 5, top=top) == pytest.approx(modes / times, rel=1e-9)


@given(strings, st.floats(0.1, 1e3))
def test_a_heavier_bit_rings_slower(string: list[Component], inertia: float) -> None:
    assert np.all(torsional_modes(string, inertia, 5) < torsional_modes(string, 0, 5))


def scanned(string: list[Component], inertia: float, top: str, highest_hz: float) -> Floats:
    """The naive twin: the product of the sections' matrices, scanned in small steps for changes of sign."""
    grid = 2 * math.pi * np.linspace(highest_hz / 1e5, highest_hz, 100_000)
    twist, torque = (0 * grid, 1 + 0 * grid) if top == "held" else (1 + 0 * grid, 0 * grid)
    for part in string:
        sine, cosine = np.sin(grid * component.delay(part)), np.cos(grid * component.delay(part))
        zeta = component.impedance(part) * grid
        twist, torque = twist * cosine + torque / zeta * sine, torque * cosine - twist * zeta * sine
    left = torque - grid**2 * inertia * twist
    at = np.flatnonzero(left[1:] * left[:-1] < 0)
    step = grid[1] - grid[0]
    roots: Floats = (grid[at] + step * left[at] / (left[at] - left[at + 1])) / (2 * math.pi)
    return roots
