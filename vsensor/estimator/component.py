"""What a component of the string is to a torsional wave (physics of a uniform shaft).

Pipe with tool joints is thick at every few metres. To waves much longer than a joint it is a uniform shaft
with the same inertia and the same compliance per metre; what parts the two lies beyond 100 Hz.
"""

import math

from vsensor.config import Component

GRAVITY = 9.80665
"""Standard gravity, m/s² (ISO 80000-3)."""


def polar_moment(part: Component) -> float:
    """Second polar moment of the body's cross section, J = π/2 (ro⁴ − ri⁴), in m⁴."""
    return math.pi / 32 * (part.outer_diameter**4 - part.inner_diameter**4)


def cross_section(part: Component) -> float:
    """Area of steel in the cross section, A = π (ro² − ri²), in m²; with tool joints, over their length."""
    body = math.pi / 4 * (part.outer_diameter**2 - part.inner_diameter**2)
    joint = math.pi / 4 * (part.tool_joint_diameter**2 - part.tool_joint_bore**2)
    return body * (1 + _share(part) * (joint / body - 1))


def buoyed_weight(part: Component, mud_density: float) -> float:
    """Weight per metre in mud (kg/m³) that stands inside and outside, N/m (API RP 7G's buoyancy factor)."""
    return (part.density - mud_density) * cross_section(part) * GRAVITY


def wave_speed(part: Component) -> float:
    """Speed of a torsional wave, c = √(G/ρ), in m/s; with tool joints 1/√(inertia · compliance) per metre."""
    return math.sqrt(part.shear_modulus / part.density) / math.sqrt(_heavier(part) * _softer(part))


def impedance(part: Component) -> float:
    """Torsional impedance ζ = J √(ρG) in N·m·s/rad: torque over speed in a wave (the paper's ξ).

    With tool joints √(inertia / compliance) per metre.
    """
    of_body = polar_moment(part) * math.sqrt(part.density * part.shear_modulus)
    return of_body * math.sqrt(_heavier(part) / _softer(part))


def stress_of_torque(part: Component) -> float:
    """Shear stress at the outer surface for each N·m, ro/J, in Pa/(N·m)."""
    return part.outer_diameter / 2 / polar_moment(part)


def delay(part: Component) -> float:
    """One-way travel time θ = L/c, in s."""
    return part.length / wave_speed(part)


def inertia(part: Component) -> float:
    """Whole moment of inertia ρJL about the axis, in kg·m²."""
    return part.density * polar_moment(part) * part.length * _heavier(part)


def stiffness(part: Component) -> float:
    """Static torsional stiffness GJ/L, in N·m/rad."""
    return part.shear_modulus * polar_moment(part) / part.length / _softer(part)


def _share(part: Component) -> float:
    """What share of the length is tool joint."""
    return part.tool_joint_length / part.joint_length


def _thicker(part: Component) -> float:
    """A tool joint's polar moment over the body's."""
    return (part.tool_joint_diameter**4 - part.tool_joint_bore**4) / (
        part.outer_diameter**4 - part.inner_diameter**4
    )


def _heavier(part: Component) -> float:
    """Inertia per metre over the body's, 1 without tool joints."""
    return 1 + _share(part) * (_thicker(part) - 1)


def _softer(part: Component) -> float:
    """Compliance per metre over the body's, 1 without tool joints."""
    return 1 + _share(part) * (1 / _thicker(part) - 1)
