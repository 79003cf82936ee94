"""What a component of the string is to a torsional wave (physics of a uniform shaft)."""

import math

from vsensor.config import Component

GRAVITY = 9.80665
"""Standard gravity, m/s² (ISO 80000-3)."""


def polar_moment(part: Component) -> float:
    """Second polar moment of the cross section, J = π/2 (ro⁴ − ri⁴), in m⁴."""
    return math.pi / 32 * (part.outer_diameter**4 - part.inner_diameter**4)


def cross_section(part: Component) -> float:
    """Area of steel in the cross section, A = π (ro² − ri²), in m²."""
    return math.pi / 4 * (part.outer_diameter**2 - part.inner_diameter**2)


def buoyed_weight(part: Component, mud_density: float) -> float:
    """Weight per metre in mud (kg/m³) that stands inside and outside, N/m (API RP 7G's buoyancy factor)."""
    return (part.density - mud_density) * cross_section(part) * GRAVITY


def wave_speed(part: Component) -> float:
    """Speed of a torsional wave, c = √(G/ρ), in m/s."""
    return math.sqrt(part.shear_modulus / part.density)


def impedance(part: Component) -> float:
    """Torsional impedance ζ = J √(ρG) in N·m·s/rad: torque over speed in a wave (the paper's ξ)."""
    return polar_moment(part) * math.sqrt(part.density * part.shear_modulus)


def stress_of_torque(part: Component) -> float:
    """Shear stress at the outer surface for each N·m, ro/J, in Pa/(N·m)."""
    return part.outer_diameter / 2 / polar_moment(part)


def delay(part: Component) -> float:
    """One-way travel time θ = L/c, in s."""
    return part.length / wave_speed(part)


def inertia(part: Component) -> float:
    """Whole moment of inertia ρJL about the axis, in kg·m²."""
    return part.density * polar_moment(part) * part.length


def stiffness(part: Component) -> float:
    """Static torsional stiffness GJ/L, in N·m/rad."""
    return part.shear_modulus * polar_moment(part) / part.length
