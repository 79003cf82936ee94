"""The march far ahead: many steps of one junction, then of the next, to the same bits as step by step.

Upward a wave takes no time (line.py), downward its section's round trip. So a junction can be passed for as
many steps at once as its wave needs to come back from below. And where it slides no step waits for the one
before: the compiler makes vectors of them.
"""

from typing import NamedTuple

from vsensor.estimator.line import pass_bit, pass_junction
from vsensor.estimator.load import Load
from vsensor.estimator.ring import mask_of, room_of
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.jit import compiled, inlined

EXTERNAL, BALANCE = range(2)
"""What a march carries from step to step beside the junctions' speeds: the further torque on the bit, and
J dω/dt of the bit."""
SHORTEST = 32
"""Junctions between which a wave goes to and fro in fewer steps are passed together, step by step: runs so
short gain nothing."""


class Span(NamedTuple):
    """Steps that are marched."""

    heard: int
    """The last step at which the top section's f is known: it is taken to stay so."""
    first: int
    """The first of them,"""
    until: int
    """the one after the last,"""
    end: int
    """and the one after the last of the whole march: what would reach the bit later does not matter."""


@compiled
def sweep(
    line: Line,
    load: Load,
    waves: Floats,
    span: Span,
    fade: float,
    speeds: Floats,
    carried: Floats,
    told: Floats,
) -> None:
    """March the string from the bit up, so far as it concerns the bit, from where it was left.

    Enters f into all sections but the top one. `speeds` (M + 1,) and `carried` (2,), the further torque on
    the bit and J dω/dt of it, are the state before, and are replaced; of the further torque a share `fade` is
    left at each following step. Each step leaves bit speed and torque in `told`, a ring by step, (2, size).
    """
    trips = line.round_trip
    last = trips.shape[0] - 1
    length = _block_length(trips, max(1, span.until - span.first))
    for first in range(span.first, span.until, length):
        block = Span(span.heard, first, min(first + length, span.until), span.end)
        top = _highest(trips, last, length)
        _turn_bit(line, load, waves, block, top, fade, speeds, carried, told)
        # So many steps of the block, where not more than it has, concern the bit.
        matters = span.end - first - _way(trips, top, last)
        while top > 0 and matters > 0:
            lowest = top - 1
            top = _highest(trips, lowest, length)
            _pass(line, waves, block, lowest, top, matters, speeds)
            matters -= _way(trips, top, lowest)


@inlined
def _way(trips: Integers, highest: int, lowest: int) -> int:
    """Steps to and fro through sections, from the highest to the lowest."""
    steps = 0
    for i in range(highest, lowest + 1):
        steps += trips[i]
    return steps


@inlined
def _block_length(trips: Integers, steps: int) -> int:
    """The most steps at once for which all but short sections have their waves already."""
    length = steps
    for i in range(1, trips.shape[0]):
        if trips[i] >= SHORTEST:
            length = min(length, trips[i])
    return length


@inlined
def _highest(trips: Integers, junction: int, length: int) -> int:
    """The highest junction that only short sections part from this one; the last is the bit."""
    while junction > 0 and trips[junction] < length:
        junction -= 1
    return junction


@inlined
def _turn_bit(
    line: Line,
    load: Load,
    waves: Floats,
    block: Span,
    top: int,
    fade: float,
    speeds: Floats,
    carried: Floats,
    told: Floats,
) -> None:
    """Turn the bit through a block, and pass the junctions up to `top`."""
    last = line.impedance.shape[0] - 1
    external, balance = carried[EXTERNAL], carried[BALANCE]
    for step in range(block.first, block.until):
        place = step & mask_of(told.shape[1])
        g, balance = pass_bit(line, load, waves, step, block.heard, external, speeds, balance, told, place)
        external *= fade
        matters = block.end - step - line.round_trip[last]
        _pass_up(line, waves, step, block.heard, last - 1, top, matters, g, speeds)
    carried[EXTERNAL], carried[BALANCE] = external, balance


@inlined
def _pass(
    line: Line, waves: Floats, block: Span, lowest: int, top: int, matters: int, speeds: Floats
) -> None:
    """Pass junctions from the lowest to `top` for the steps that matter, where g waits in the place of f."""
    mask = mask_of(waves.shape[1])
    run = min(block.until - block.first, matters)
    if lowest == top and _slides(line, waves, block, top, run, speeds[top + 1]):
        onward = min(run, matters - line.round_trip[top]) if top > 0 else 0
        speeds[top + 1] = _slide(line, waves, block.first, top, run, onward)
        return
    for k in range(run):
        step = block.first + k
        g = waves[lowest + 1, step & mask]
        _pass_up(line, waves, step, block.heard, lowest, top, matters - k, g, speeds)


@inlined
def _pass_up(
    line: Line,
    waves: Floats,
    step: int,
    heard: int,
    lowest: int,
    top: int,
    matters: int,
    g: float,
    speeds: Floats,
) -> None:
    """Pass junctions from the lowest to `top` at one step, and leave g where the next is to enter f."""
    for i in range(lowest, top - 1, -1):
        if i < 0 or matters <= 0:  # the first is never so; but said, it spares the compiler some care
            return
        g = pass_junction(line, waves, i, step, heard, g, speeds)
        matters -= line.round_trip[i]
    if top > 0 and matters > 0:
        waves[top, step & mask_of(waves.shape[1])] = g


@inlined
def _slides(line: Line, waves: Floats, block: Span, i: int, run: int, before: float) -> bool:
    """Whether the junction below section i slides at each step of a run, and all f of that are heard."""
    trip, size = line.round_trip[i], room_of(waves.shape[1])
    if before == 0 or (i == 0 and block.first + run - 1 - trip > block.heard):
        return False
    kinetic = line.kinetic[i + 1]
    rests = 0
    done = 0
    while done < run:
        at, source = (block.first + done) & (size - 1), (block.first + done - trip) & (size - 1)
        count = min(run - done, size - at, size - source)
        f, g = waves[i, source : source + count], waves[i + 1, at : at + count]
        for k in range(count):
            rests += abs(f[k] - g[k]) <= kinetic
        done += count
    return rests == 0


@inlined
def _slide(line: Line, waves: Floats, first: int, i: int, run: int, onward: int) -> float:
    """Pass a junction that slides through a run, leave g of the first `onward` steps; returns its speed."""
    trip, size = line.round_trip[i], room_of(waves.shape[1])
    z, below, kinetic = line.impedance[i], line.impedance[i + 1], line.kinetic[i + 1]
    mobility = 1.0 / (z + below + line.viscous[i + 1])
    w = 0.0
    done = 0
    while done < run:
        at, source = (first + done) & (size - 1), (first + done - trip) & (size - 1)
        count = min((onward if done < onward else run) - done, size - at, size - source)
        f, g, up = waves[i, source : source + count], waves[i + 1, at : at + count], waves[i, at : at + count]
        if done < onward:
            for k in range(count):
                drive = f[k] - g[k]
                w = (drive - kinetic if drive > 0 else drive + kinetic) * mobility
                g[k] += 2 * below * w
                up[k] = f[k] - 2 * z * w
        else:
            for k in range(count):
                drive = f[k] - g[k]
                w = (drive - kinetic if drive > 0 else drive + kinetic) * mobility
                g[k] += 2 * below * w
        done += count
    return w
