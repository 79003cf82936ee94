"""Torque and speed all along the string at one and the same moment, that of the confirmed answer.

Slanted time sees each depth one travel time late: at step k as it was at k − θ. To see all depths as
they were at one time c, a section whose top is θ down is looked up x (in time) below its top by what
stands there of the waves at its top:

    f at step c + θ − x, g at step c + θ + x

The latest such c is the time of the confirmed answer, one travel time τ before the last confirmed step.

Innovations correct f at once where it is still in its section, since the string runs on with it. What
they say of f from then on, and of g, is asked for here alone, some ten times a second, and added only then.

Friction, which the sections have at their junctions, is spread evenly again over the sections between
them, so that torque is continuous: at the top it is the measured one, at the bottom the confirmed one.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vsensor.config import Component
from vsensor.estimator.line import rubbing
from vsensor.estimator.ring import mask_of, weighted
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


class Heard(NamedTuple):
    """The last innovations, and what they say of the waves of before them."""

    of_waves: Floats
    """Corrections of f at each section's top by an innovation of 1 rad/s, for each level of the rock, newest
    last; shape (C, M, L);"""
    inside: Integers
    """but for so many newest steps, which it corrected at once, shape (M,)."""
    of_returned: Floats
    """Of g there, laid out like those of f."""
    innovations: Floats
    """By tick, rad/s, 0 where there was none; a ring."""
    levels: Integers
    """The level of the rock at each, laid out alike."""
    newest: int
    """The last of those ticks."""
    steps: int
    """Internal steps in a tick."""


def stations(string: Sequence[Component], line: Line, junctions: Floats) -> Stations:
    """Lay out the stations on a string cut into `line`, whose junctions are at these depths (m)."""
    depth, component, seen = station_depths(string)
    last = len(line.impedance) - 1
    section = np.clip(np.searchsorted(junctions, seen, side="right") - 1, 0, last)
    # Both sides of a joint inside a section are one place.
    share = np.clip((depth - junctions[section]) / np.diff(junctions)[section], 0.0, 1.0)
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


def station_depths(string: Sequence[Component]) -> tuple[Floats, Integers, Floats]:
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
def along(
    line: Line, waves: Floats, returned: Floats, heard: Heard, at: Stations, common: int, told: Floats
) -> None:
    """Fill `told` (2, n) with speed, rad/s, and torque, N·m, at the stations at internal step `common`.

    `waves` and `returned` (M, size) hold f and g at the sections' tops, without what was `heard` of them
    afterwards. No allocation.
    """
    mask = mask_of(waves.shape[1])
    # No wave is looked up longer before than it takes to the bit.
    since = alike_since(heard, (common - at.down[-1] - at.inside[-1]) // heard.steps)
    for k in range(at.section.shape[0]):
        i = at.section[k]
        step = common + at.down[k]
        left, came = step - at.inside[k], step + at.inside[k]
        f = waves[i, left & mask] + late_correction(heard, since, heard.of_waves[:, i], left, heard.inside[i])
        g = returned[i, came & mask] + late_correction(heard, since, heard.of_returned[:, i], came, 0)
        w = 0.5 * (f - g) / line.impedance[i]
        rubbed = at.above[k] * rubbing(line, i, w) - at.below[k] * rubbing(line, i + 1, w)
        told[SPEED, k] = w
        told[TORQUE, k] = 0.5 * (f + g) + rubbed


@compiled
def alike_since(heard: Heard, first: int) -> int:
    """The tick, no earlier than `first`, since which innovations are weighed by the same level's gains."""
    size = heard.innovations.shape[0]
    since, at = heard.newest, heard.newest % size
    level, first = heard.levels[at], max(first, heard.newest - size + 1, 0)
    while since > first and heard.levels[at - 1] == level:  # -1 is the ring's last
        since, at = since - 1, at - 1
    return since


@compiled
def late_correction(heard: Heard, since: int, of_innovation: Floats, step: int, least: int) -> float:
    """What innovations at least so many steps after a step say of a wave by gains (C, L).

    `since` is told by `alike_since`.
    """
    size, lag = heard.innovations.shape[0], of_innovation.shape[1] // heard.steps
    tick, end = (step + least) // heard.steps, min(step // heard.steps + lag, heard.newest + 1)
    tick = max(tick, heard.newest - size + 1)
    total = 0.0
    while tick < end:
        level = heard.levels[tick % size]
        gain = of_innovation.shape[1] - (tick + 1) * heard.steps + step
        if tick < since:
            total += of_innovation[level, gain] * heard.innovations[tick % size]
            tick += 1
        else:
            # As far as the ring goes without a turn.
            at = tick % size
            until = at + min(end - tick, size - at)
            gains = of_innovation[level, : gain + 1]
            total += weighted(gains, heard.steps, heard.innovations[at:until])
            tick += until - at
    return total


def catch_up(heard: Heard, waves: Floats, returned: Floats) -> None:
    """Correct all waves, (M, size) each, by what was heard of them so far."""
    # room_of would be compiled here, while the string is made longer; mask_of has been long before.
    size, lag = mask_of(waves.shape[1]) + 1, heard.of_waves.shape[2]
    late = np.arange(lag) < lag - heard.inside[:, None]
    for before in range(min(len(heard.innovations), -(-size // heard.steps))):
        at = (heard.newest - before) % len(heard.innovations)
        last = (heard.newest - before + 1) * heard.steps - 1
        count = min(lag, size - before * heard.steps)
        places = (last + 1 - count + np.arange(count)) % size
        innovation, level = heard.innovations[at], heard.levels[at]
        waves[:, places] += (innovation * heard.of_waves[level] * late)[:, lag - count :]
        returned[:, places] += (innovation * heard.of_returned[level])[:, lag - count :]


@compiled
def keep_returned(line: Line, waves: Floats, speeds: Floats, step: int, returned: Floats) -> None:
    """Enter g at the sections' tops at a step that was marched, from the speeds (M + 1,) of its junctions.

    The wave that comes back from a section's bottom is g = f − 2ζω there, in slanted time at the same step.
    """
    mask = mask_of(waves.shape[1])
    for i in range(line.impedance.shape[0]):
        arrived = waves[i, (step - line.round_trip[i]) & mask]
        returned[i, step & mask] = arrived - 2 * line.impedance[i] * speeds[i + 1]
