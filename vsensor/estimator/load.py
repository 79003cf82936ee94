"""What the bit meets: the load law between bit and rock, and contact with friction."""

import math
from typing import NamedTuple

from vsensor.config import Bit
from vsensor.estimator.exponential import exponential
from vsensor.estimator.sections import Line
from vsensor.jit import compiled, inlined

CLOSE = 1e-12
"""The bit's speed is found to so small a share of itself,"""
MOST = 50
"""in no more than so many steps."""


class Load(NamedTuple):
    """A load law: T(ω) = viscous ω + sign ω (kinetic + (static − kinetic) e^(−|ω|/stribeck)).

    At rest the torque is whatever holds the bit, up to `static` (Stribeck friction with an
    exponential fall, Armstrong-Hélouvry 1994).
    """

    viscous: float
    kinetic: float
    static: float
    stribeck: float
    inertia_rate: float
    """2 J / Δt of the bit, N·m·s/rad: what its inertia adds to the impedance it shows (trapezoid rule)."""


def load_of(bit: Bit, step_s: float) -> Load:
    """The configured first guess of the load law, for steps of `step_s`."""
    return Load(
        bit.viscous_friction,
        bit.kinetic_torque,
        bit.static_torque,
        bit.stribeck_speed,
        2 * bit.inertia / step_s,
    )


@compiled
def law(load: Load, speed: float) -> float:
    """Torque of the load law at a speed, N·m; 0 at rest."""
    if speed == 0:
        return 0.0
    x = abs(speed)
    coulomb = load.kinetic + (load.static - load.kinetic) * exponential(-x / load.stribeck)
    return load.viscous * speed + math.copysign(coulomb, speed)


class Foot(NamedTuple):
    """What the bit hangs on: the last section's impedance and the friction lumped at its bottom."""

    impedance: float
    viscous: float
    kinetic: float
    static: float


@inlined
def foot(line: Line) -> Foot:
    """The foot of a line."""
    end = line.impedance.shape[0]
    return Foot(
        float(line.impedance[end - 1]),
        float(line.viscous[end]),
        float(line.kinetic[end]),
        float(line.static[end]),
    )


@inlined
def turning(load: Load, at: Foot, f: float, speed: float) -> float:
    """J dω/dt of a bit that slides at `speed` while the wave f arrives, N·m; 0 at rest or without inertia."""
    if speed == 0 or load.inertia_rate == 0:
        return 0.0
    rubbing = at.viscous * speed + math.copysign(at.kinetic, speed)
    return f - at.impedance * speed - rubbing - law(load, speed)


@inlined
def contact(drive: float, mobility: float, kinetic: float, static: float, before: float) -> float:
    """Speed w of a junction: w / mobility + Coulomb friction = drive; rests until `static` is passed.

    Whoever has the mobility before the drive need not wait for a division, nor make it again.
    """
    held = static if before == 0 else kinetic
    if abs(drive) <= held:
        return 0.0
    return math.copysign(abs(drive) - kinetic, drive) * mobility


@compiled
def turn_bit(load: Load, at: Foot, f: float, before: float, balance: float) -> tuple[float, float]:
    """Turn the bit by one step: J dω/dt = f − ζω − load law − the foot's friction.

    `before` and `balance` are ω and J dω/dt of the step before; returns those of this step.
    """
    drive = f + load.inertia_rate * before + balance
    if before == 0 and abs(drive) <= load.static + at.static:
        return 0.0, 0.0
    resistance = load.inertia_rate + at.impedance + at.viscous + load.viscous
    x = _sliding(load, abs(drive) - load.kinetic - at.kinetic, resistance)
    if x == 0:
        return 0.0, 0.0
    w = math.copysign(x, drive)
    return w, load.inertia_rate * (w - before) - balance


@inlined
def _sliding(load: Load, drive: float, resistance: float) -> float:
    """Solve resistance·x + (static − kinetic) e^(−x/stribeck) = drive for the fastest x ≥ 0; else 0.

    The left side is convex and at least `drive` at the start, so that Newton's steps come down on
    the fastest solution from above.
    """
    x = drive * (1.0 / resistance)
    fall = load.static - load.kinetic
    if x <= 0 or fall == 0:
        return max(x, 0.0)
    rate = 1.0 / load.stribeck
    for _ in range(MOST):
        gone = fall * exponential(-x * rate)
        slope = gone * rate
        steep = resistance - slope
        if steep <= 0:
            return 0.0
        change = (resistance * x + gone - drive) / steep
        x -= change
        if x <= 0:
            return 0.0
        # By Taylor what is missing still is half of this, for all that it went with the last change squared.
        if slope * rate * change * change <= CLOSE * x * steep:
            break
    return x
