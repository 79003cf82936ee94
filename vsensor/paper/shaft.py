"""The paper's shaft, its load and its torque: Table II, and the text around it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vsensor.config import Component
from vsensor.estimator import component

Floats = NDArray[np.float64]

SHAFT = Component(
    name="drill pipe",
    length=4000.0,
    outer_diameter=2 * 0.0841,
    inner_diameter=2 * 0.074942,
    shear_modulus=79.6e9,
    density=8009.0,
)
"""Table II."""

TORQUE = 7000.0
"""What the prime mover steps to at time 0, N·m."""

BIT_INERTIA = 1570.0
"""Collars and bit, J_b, kg·m²."""

DAMPING = 400.0
"""D_L = C_r + C_b, all of it at the bit, N·m·s/rad."""

_PIPE_INERTIA = 930.0
_STIFFNESS = 580.0


class Load(NamedTuple):
    """What turns at the shaft's end, eq. (19): T₁ = J dω₁/dt + D ω₁."""

    inertia: float
    """kg·m²."""
    damping: float
    """N·m·s/rad."""


class Trace(NamedTuple):
    """One quantity over time, both of shape (n,); times ascend, in s."""

    time: Floats
    value: Floats


class Response(NamedTuple):
    """The shaft's answer to a torque: speeds in rad/s, torque in N·m."""

    top: Trace
    """Speed where the torque comes in, ω₀."""
    end: Trace
    """Speed of the load, ω₁."""
    end_torque: Trace
    """Torque from the shaft into the load, T₁."""


BIT = Load(BIT_INERTIA, DAMPING)
"""The load with every inertia counted once: the shaft's own is in its equations already."""


def of_length(length: float) -> Component:
    """The paper's shaft, but this long (m)."""
    return SHAFT.model_copy(update={"length": length})


def pipe_inertia(shaft: Component) -> float:
    """J_r of the lumped model: ρJL, for 4000 m rounded to 930 kg·m² as the paper has it."""
    return _PIPE_INERTIA * shaft.length / SHAFT.length


def stiffness(shaft: Component) -> float:
    """k of the lumped model: GJ/L, for 4000 m rounded (up) to 580 N·m/rad as the paper has it."""
    return _STIFFNESS * SHAFT.length / shaft.length


def load_as_printed(shaft: Component) -> Load:
    """The paper's load, J_L = J_r + J_b: it adds the shaft's own inertia to the line that has it already."""
    return Load(BIT_INERTIA + pipe_inertia(shaft), DAMPING)


def shear_stress(shaft: Component, torque: ArrayLike) -> Floats:
    """Shear stress T·r_o/J at the shaft's outer surface, Pa, in the shape of `torque` (N·m)."""
    outer_radius = shaft.outer_diameter / 2
    return np.asarray(np.multiply(torque, outer_radius / component.polar_moment(shaft)))
