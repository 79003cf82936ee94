"""The string that the kernels are measured on: long, and of many parts."""

from vsensor.config import Rig, loads

RIG = """
[rig]
name = "bench"
[top_drive]
inertia = "2000 kg*m^2"
torque_lag = "5 ms"
[bit]
inertia = "50 kg*m^2"
viscous_friction = "5 N*m*s/rad"
kinetic_torque = "3 kN*m"
static_torque = "8 kN*m"
stribeck_speed = "1.5 rad/s"
[loop]
rate = {rate}
"""

COMPONENTS = (
    ("drill pipe, 5 1/2 in", "2300 m", "5.5 in", "4.778 in", 0.3),
    ("drill pipe, 5 in", "2200 m", "5 in", "4.276 in", 0.3),
    ("heavy-weight drill pipe", "180 m", "5 in", "3 in", 0.4),
    ("jar", "12 m", "6.5 in", "2.75 in", 0.5),
    ("heavy-weight drill pipe", "90 m", "5 in", "3 in", 0.4),
    ("drill collars, 8 in", "120 m", "8 in", "2.8125 in", 0.5),
    ("stabiliser", "12 m", "8 in", "2.8125 in", 0.8),
    ("drill collars, 6 3/4 in", "60 m", "6.75 in", "2.8125 in", 0.5),
    ("measurement while drilling", "14 m", "6.75 in", "3 in", 0.5),
    ("motor", "12 m", "6.75 in", "4 in", 0.5),
)
"""Name, length, outer and inner diameter, Coulomb friction in N·m per metre: 5000 m together."""

COMPONENT = """
[[string]]
name = "{}"
length = "{}"
outer_diameter = "{}"
inner_diameter = "{}"
viscous_friction = 0.02
coulomb_friction = {}
"""


def deep_well(rate_hz: float) -> Rig:
    """A rig with 5 km of string in ten components. Raises ConfigError where the rate is impossible."""
    return loads(RIG.format(rate=rate_hz) + "".join(COMPONENT.format(*c) for c in COMPONENTS), "--rate")
