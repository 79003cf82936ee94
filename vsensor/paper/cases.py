"""Three systems that others published, run by our models.

Parameters are the publications'; what they are held against was simulated once, independently.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from vsensor.config import Bit, TopDrive
from vsensor.estimator.forward import ForwardLine
from vsensor.estimator.sections import Line
from vsensor.paper.chain import Chain, Motion, simulate, stribeck
from vsensor.paper.general_line import Complexes, GeneralLine
from vsensor.paper.shaft import Floats, Trace


class Outcome(NamedTuple):
    """One figure of a case: what it should be, and what our models give."""

    case: str
    quantity: str
    unit: str
    expected: float
    ours: float


_WEIGHT_ON_BIT = 97347.0
_BIT_RADIUS = 0.155575
KINETIC = 0.5 * _WEIGHT_ON_BIT * _BIT_RADIUS
"""μ W r of a sliding bit, N·m."""
STATIC = 0.8 * _WEIGHT_ON_BIT * _BIT_RADIUS
"""μ W r of a bit at rest, N·m."""
FADE_SPEED = 1 / 0.9
"""Friction falls from one to the other as e^(−0.9 |ω|); rad/s."""

FOUR_INERTIAS = Chain(
    inertia=np.array([930.0, 2782.25, 750.0, 471.97]),
    stiffness=np.array([698.063, 1080.0, 907.48]),
    damping=np.array([139.6126, 190.0, 181.49]),
    drag=np.array([425.0, 0.0, 0.0, 50.0]),
)
"""Top drive, pipe, collars and bit of Navarro-López and Cortés (2007), the paper's reference [3]."""


def four_inertias(torque: float, until: float) -> Motion:
    """Stick-slip of four inertias under a constant motor torque (N·m), to `until` (s)."""
    return simulate(FOUR_INERTIAS, stribeck(KINETIC, STATIC, FADE_SPEED), torque, until)


class Shaft(NamedTuple):
    """The string of Saldivar and others (2011): a shaft whose motor pulls by c_a (Ω − ω₀)."""

    shear_modulus: float = 79.3e9
    inertia: float = 0.095
    """Per metre, kg·m."""
    length: float = 1172.0
    moment: float = 1.19e-5
    """Polar second moment, m⁴."""
    bit_inertia: float = 311.0
    motor: float = 2000.0
    """c_a, N·m·s/rad."""
    bit_drag: float = 0.03
    """c_b, N·m·s/rad."""


def neutral_delay(speed: float, until: float, steps: int, shaft: Shaft | None = None) -> Trace:
    """The bit's speed for a motor that wants `speed` (rad/s), in `steps` steps for each one-way delay.

    The wave equation with these ends is their neutral delay equation; our kernels run the wave
    itself. The motor's pull is a torque c_a Ω and a viscous drag c_a at the top.
    """
    given = shaft or Shaft()
    rigidity = given.shear_modulus * given.moment
    step = given.length * np.sqrt(given.inertia / rigidity) / steps
    line = Line(
        impedance=np.array([np.sqrt(given.inertia * rigidity)]),
        round_trip=np.array([2 * steps]),
        viscous=np.array([given.motor, 0.0]),
        kinetic=np.zeros(2),
        static=np.zeros(2),
        depth=np.array([0.0, steps]),
    )
    bit = Bit(
        inertia=given.bit_inertia,
        viscous_friction=given.bit_drag,
        kinetic_torque=KINETIC,
        static_torque=STATIC,
        stribeck_speed=FADE_SPEED,
    )
    count = int(until / step)
    string = ForwardLine(line, TopDrive(), bit, float(step))
    _, bit_speed, _ = string.run(np.full(count, given.motor * speed), np.zeros(count))
    return Trace((np.arange(count) + 0.5) * step - string.bit_delay, bit_speed)


def period(broke_loose: Floats) -> float:
    """Mean time from one breaking loose to the next, over their later half, s; NaN for fewer than 3."""
    late = broke_loose[len(broke_loose) // 2 :]
    return float(np.diff(late).mean()) if len(broke_loose) > 2 else float("nan")


def breaks_loose(speed: Trace) -> Floats:
    """When a speed leaves zero, s."""
    moves = speed.value != 0
    starts: Floats = speed.time[1:][moves[1:] & ~moves[:-1]]
    return starts


_WAVE_SPEED = 2787.6
PIPE_AND_COLLARS = tuple(
    GeneralLine(length, inertance=zeta / _WAVE_SPEED, compliance=1 / (zeta * _WAVE_SPEED))
    for length, zeta in ((2270.0, 498.26), (230.0, 1858.65))
)
"""Top down; lengths in m, impedances in N·m·s/rad, one wave speed for both."""


def modes(lines: tuple[GeneralLine, ...], below_hz: float) -> Floats:
    """Natural frequencies (Hz) of lossless lines in a row, the top held (y = 0), the bottom free (u = 0).

    The bottom's u for one at the top is an entry of the lines' product, real at s = jΩ; its zeros are
    bracketed on a grid and found by Brent's method.
    """

    def left_over(hertz: float) -> float:
        s = 2j * np.pi * hertz
        through: Complexes = np.eye(2, dtype=np.complex128)
        for line in lines:
            through = line.chain(s) @ through
        return float(through[0, 0].real)

    grid = np.linspace(0, below_hz, 2001)[1:]
    values = np.array([left_over(hertz) for hertz in grid])
    at = np.flatnonzero(values[1:] * values[:-1] < 0)
    return np.array([brentq(left_over, grid[i], grid[i + 1]) for i in at])


def outcomes(
    stick_slip: Motion, smooth: Motion, delayed: Trace, delayed_smooth: Trace
) -> tuple[Outcome, ...]:
    """What comes of four inertias at 10 and 12 kN·m, and of the delayed shaft at 10 and 15 rad/s."""
    four, delay = "four inertias", "neutral delay"
    found = modes(PIPE_AND_COLLARS, below_hz=1.5)
    return (
        Outcome(four, "10 kN·m: period of stick-slip", "s", 8.25, period(stick_slip.times("sliding"))),
        Outcome(
            four, "10 kN·m: greatest speed of the bit", "rad/s", 6.78, _late(stick_slip.speeds[-1]).max()
        ),
        Outcome(four, "12 kN·m: steady speed of the bit", "rad/s", 9.32, smooth.speeds[-1][-1]),
        Outcome(delay, "10 rad/s: period of stick-slip", "s", 4.72, period(breaks_loose(delayed))),
        Outcome(delay, "10 rad/s: greatest speed of the bit", "rad/s", 14.1, _late(delayed.value).max()),
        Outcome(
            delay,
            "15 rad/s: swing of the bit that is left",
            "rad/s",
            0.0,
            np.ptp(_late(delayed_smooth.value)),
        ),
        *(
            Outcome("pipe and collars", f"mode {n}", "Hz", expected, ours)
            for n, (expected, ours) in enumerate(zip((0.2261, 0.7300, 1.2918), found, strict=True), 1)
        ),
    )


def _late(values: Floats) -> Floats:
    return values[len(values) // 2 :]
