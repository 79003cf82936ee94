"""The march far ahead: many steps of one junction, then of the next, to the same bits as step by step.

Upward a wave takes no time (line.py), downward its section's round trip. So a junction can be passed for as
many steps at once as its wave needs to come back from below. And where it slides no step waits for the one
before: the compiler makes vectors of them.
"""

from typing import NamedTuple

from vsensor.estimator.line import pass_bit, pass_junction
from vsensor.estimator.load import Load
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.jit import compiled

SHORTEST = 32
"""Junctions between which a wave goes to and fro in fewer steps are passed together, step by step: runs so
short gain nothing."""


class Block(NamedTuple):
    """Steps that are marched together."""

    known: int
    """The step from which the whole march sets out;"""
    first: int
    """the block's first,"""
    length: int
    """how many it has,"""
    left: int
    """and how many there are from the first to the end of the march."""


@compiled
def sweep(
    line: Line,
    load: Load,
    waves: Floats,
    known: int,
    steps: int,
    external: float,
    fade: float,
    speeds: Floats,
    balance: float,
    told: Floats,
) -> None:
    """March the string from the bit up for `steps` steps after step `known`, so far as they concern the bit.

    Junctions whose wave would not reach the bit within these steps are spared. Enters f into all sections but
    the top one, whose f is taken to stay as at `known`. `speeds` (M + 1,) and `balance`, J dω/dt of the bit,
    are the state at `known`; the first is replaced. Each step leaves bit speed and torque in `told`
    (2, ≥ steps). `external` is a further torque on the bit, of which a share `fade` is left at each
    following step.
    """
    trips = line.round_trip
    last = trips.shape[0] - 1
    length = _block_length(trips, steps)
    for done in range(0, steps, length):
        block = Block(known, known + 1 + done, min(length, steps - done), steps - done)
        top = _highest(trips, last, length)
        external, balance = _turn_bit(line, load, waves, block, top, external, fade, speeds, balance, told)
        # So many steps of the block, where not more than it has, concern the bit.
        matters = block.left - _way(trips, top, last)
        while top > 0 and matters > 0:
            lowest = top - 1
            top = _highest(trips, lowest, length)
            _pass(line, waves, block, lowest, top, matters, speeds)
            matters -= _way(trips, top, lowest)


@compiled
def _way(trips: Integers, highest: int, lowest: int) -> int:
    """Steps to and fro through sections, from the highest to the lowest."""
    steps = 0
    for i in range(highest, lowest + 1):
        steps += trips[i]
    return steps


@compiled
def _block_length(trips: Integers, steps: int) -> int:
    """The most steps at once for which all but short sections have their waves already."""
    length = steps
    for i in range(1, trips.shape[0]):
        if trips[i] >= SHORTEST:
            length = min(length, trips[i])
    return length


@compiled
def _highest(trips: Integers, junction: int, length: int) -> int:
    """The highest junction that only short sections part from this one; the last is the bit."""
    while junction > 0 and trips[junction] < length:
        junction -= 1
    return junction


@compiled
def _turn_bit(
    line: Line,
    load: Load,
    waves: Floats,
    block: Block,
    top: int,
    external: float,
    fade: float,
    speeds: Floats,
    balance: float,
    told: Floats,
) -> tuple[float, float]:
    """Turn the bit through a block, and pass the junctions up to `top`; returns `external` and balance."""
    last = line.impedance.shape[0] - 1
    for k in range(block.length):
        step = block.first + k
        g, balance = pass_bit(
            line, load, waves, step, block.known, external, speeds, balance, told, step - block.known - 1
        )
        external *= fade
        matters = block.left - k - line.round_trip[last]
        _pass_up(line, waves, step, block.known, last - 1, top, matters, g, speeds)
    return external, balance


@compiled
def _pass(
    line: Line, waves: Floats, block: Block, lowest: int, top: int, matters: int, speeds: Floats
) -> None:
    """Pass junctions from the lowest to `top` for the steps that matter, where g waits in the place of f."""
    mask = waves.shape[1] - 1
    run = min(block.length, matters)
    if lowest == top and _slides(line, waves, block, top, run, speeds[top + 1]):
        onward = min(run, matters - line.round_trip[top]) if top > 0 else 0
        speeds[top + 1] = _slide(line, waves, block.first, top, run, onward)
        return
    for k in range(run):
        step = block.first + k
        g = waves[lowest + 1, step & mask]
        _pass_up(line, waves, step, block.known, lowest, top, matters - k, g, speeds)


@compiled
def _pass_up(
    line: Line,
    waves: Floats,
    step: int,
    known: int,
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
        g = pass_junction(line, waves, i, step, known, g, speeds)
        matters -= line.round_trip[i]
    if top > 0 and matters > 0:
        waves[top, step & (waves.shape[1] - 1)] = g


@compiled
def _slides(line: Line, waves: Floats, block: Block, i: int, run: int, before: float) -> bool:
    """Whether the junction below section i slides at each step of a run, and all f of that are heard."""
    trip, size = line.round_trip[i], waves.shape[1]
    if before == 0 or (i == 0 and block.first + run - 1 - trip > block.known):
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


@compiled
def _slide(line: Line, waves: Floats, first: int, i: int, run: int, onward: int) -> float:
    """Pass a junction that slides through a run, leave g of the first `onward` steps; returns its speed."""
    trip, size = line.round_trip[i], waves.shape[1]
    z, below, kinetic = line.impedance[i], line.impedance[i + 1], line.kinetic[i + 1]
    resistance = z + below + line.viscous[i + 1]
    w = 0.0
    done = 0
    while done < run:
        at, source = (first + done) & (size - 1), (first + done - trip) & (size - 1)
        count = min((onward if done < onward else run) - done, size - at, size - source)
        f, g, up = waves[i, source : source + count], waves[i + 1, at : at + count], waves[i, at : at + count]
        if done < onward:
            for k in range(count):
                drive = f[k] - g[k]
                w = (drive - kinetic if drive > 0 else drive + kinetic) / resistance
                g[k] += 2 * below * w
                up[k] = f[k] - 2 * z * w
        else:
            for k in range(count):
                drive = f[k] - g[k]
                w = (drive - kinetic if drive > 0 else drive + kinetic) / resistance
                g[k] += 2 * below * w
        done += count
    return w
