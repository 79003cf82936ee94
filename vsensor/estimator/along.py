"""Torque and speed all along the string at one and the same moment, that of the confirmed answer.

Slanted time sees each depth one travel time late: at step k as it was at k − θ. To see all depths as
they were at one time c, a section whose top is θ down is looked up x (in time) below its top by what
stands there of the waves at its top:

    f at step c + θ − x, g at step c + θ + x

The latest such c is the time of the confirmed answer, one travel time τ before the last confirmed step.

Friction, which the sections have at their junctions, is spread evenly again over the sections between
them, so that torque is continuous: at the top it is the measured one, at the bottom the confirmed one.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vsensor.config import Component
from vsensor.estimator.line import rubbing
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.jit import compiled

INTERVALS = 50
"""The string is told at its components' ends and in so many steps of equal length between them."""
INSIDE = 1e-6
"""The ends of a component are told this far inside it (m): a junction has two sides."""

SPEED, TORQUE = range(2)
"""Rows of what is told."""


class Stations(NamedTuple):
    """Where along the string it is told: n depths, top down, twice where two components meet."""

    depth: Floats
    """m along the string, shape (n,)."""
    component: Integers
    """Which component of the string it is, shape (n,)."""
    section: Integers
    """Which section, shape (n,)."""
    down: Integers
    """Internal steps that a wave takes from the string's top to that section's, θ, shape (n,)."""
    inside: Integers
    """and from there to the station, x, shape (n,)."""
    above: Floats
    """Share of the friction of the junction above that is met only below the station, shape (n,)."""
    below: Floats
    """Share of the friction of the junction below that is met above it already, shape (n,)."""


def stations(string: Sequence[Component], line: Line, junctions: Floats) -> Stations:
    """Lay out the stations on a string cut into `line`, whose junctions are at these depths (m)."""
    depth, component, seen = _depths(string)
    last = len(line.impedance) - 1
    section = np.clip(np.searchsorted(junctions, seen, side="right") - 1, 0, last)
    share = np.clip((seen - junctions[section]) / np.diff(junctions)[section], 0.0, 1.0)
    steps = line.round_trip // 2
    inside = np.floor(share * steps[section] + 0.5).astype(np.int64)
    share = inside / steps[section]
    return Stations(
        depth=depth,
        component=component,
        section=section,
        down=np.cumsum(steps)[section] - steps[section],
        inside=inside,
        above=(1 - share) * np.where(section == 0, 1.0, 0.5),
        below=share * np.where(section == last, 1.0, 0.5),
    )


def _depths(string: Sequence[Component]) -> tuple[Floats, Integers, Floats]:
    """Each station's depth, its component, and the depth with the ends moved inside; shapes (n,)."""
    spacing = sum(part.length for part in string) / INTERVALS
    depths, components, seen = [], [], []
    top = 0.0
    for number, part in enumerate(string):
        count = math.ceil(part.length / spacing * (1 - 1e-9)) + 1
        told = np.linspace(top, top + part.length, count)
        depths.append(told)
        components.append(np.full(count, number))
        seen.append(np.clip(told, top + INSIDE, top + part.length - INSIDE))
        top += part.length
    return np.concatenate(depths), np.concatenate(components), np.concatenate(seen)


@compiled
def along(line: Line, waves: Floats, returned: Floats, at: Stations, common: int, told: Floats) -> None:
    """Fill `told` (2, n) with speed, rad/s, and torque, N·m, at the stations at internal step `common`.

    `waves` and `returned` (M, size) hold f and g at the sections' tops. No allocation.
    """
    mask = waves.shape[1] - 1
    for k in range(at.section.shape[0]):
        i = at.section[k]
        step = common + at.down[k]
        f = waves[i, (step - at.inside[k]) & mask]
        g = returned[i, (step + at.inside[k]) & mask]
        w = 0.5 * (f - g) / line.impedance[i]
        rubbed = at.above[k] * rubbing(line, i, w) - at.below[k] * rubbing(line, i + 1, w)
        told[SPEED, k] = w
        told[TORQUE, k] = 0.5 * (f + g) + rubbed


@compiled
def keep_returned(line: Line, waves: Floats, speeds: Floats, step: int, returned: Floats) -> None:
    """Enter g at the sections' tops at a step that was marched, from the speeds (M + 1,) of its junctions.

    The wave that comes back from a section's bottom is g = f − 2ζω there, in slanted time at the same step.
    """
    mask = waves.shape[1] - 1
    for i in range(line.impedance.shape[0]):
        arrived = waves[i, (step - line.round_trip[i]) & mask]
        returned[i, step & mask] = arrived - 2 * line.impedance[i] * speeds[i + 1]
