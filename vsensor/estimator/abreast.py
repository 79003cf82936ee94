"""The marches of many ticks at once, side by side; what a march is stands in ahead.py.

Each step of a march waits for the one before, and the processor with it. But nothing of a march goes back
into the observer, and what it foretells is not asked for until it can be confirmed. So over a record the
observer goes on for some ticks, each of which leaves what its march sets out from; then all of them march in
step, a lane each, and the compiler makes vectors of the lanes. They come to the same bits as one by one.
"""

import math
from typing import NamedTuple

import numpy as np

from vsensor.estimator.ahead import reach, time_to
from vsensor.estimator.bits import (
    BALANCE,
    EXTERNAL,
    LANES,
    PARTS,
    SPEED,
    move_bits,
    set_out_bit,
    tell_torques,
    turn_bits,
)
from vsensor.estimator.learn import load_in_force
from vsensor.estimator.ring import mask_of
from vsensor.estimator.score import HORIZONS
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.estimator.state import BIT, Model, State
from vsensor.jit import COMPILED, inlined

WORTHWHILE = 16
"""Fewer are done sooner one by one."""


class Room(NamedTuple):
    """Room for LANES marches, nothing of which is needed once they were told of."""

    kept: Floats
    """The waves f at the sections' tops as of each tick, the last round trip of each, shape (LANES, …);"""
    waves: Floats
    """and as the marches go on: of each section a delay line, shape (M, longest, LANES)."""
    held: Floats
    """The newest f of the top section, which is taken to stay so, shape (LANES,)."""
    rows: Integers
    """The row of each section's line that stands at its bottom, and is entered anew, shape (M,)."""
    speeds: Floats
    """Of the junctions, shape (M + 1, LANES)."""
    bits: Floats
    """Of the bits, as bits.py has it."""
    told: Floats
    """Speed of each at each step, and torque where it is asked for, shape (2, steps, LANES)."""
    asked: Integers
    """Whether it is, 0 or 1, shape (steps,)."""
    rests: Integers
    """For how many steps each bit has been at rest, shape (LANES,)."""
    sticks: Floats
    """Time until each is foretold to stick, as `ahead.stick_ahead` has it, s, shape (LANES,)."""


def room_for(model: Model) -> Room:
    """Room for the marches of a model, whatever its delays are corrected to."""
    sections, longest = len(model.inside), int(model.inside.sum())
    steps = model.behind * model.steps + longest + model.lasting
    return Room(
        kept=np.zeros((LANES, longest)),
        waves=np.zeros((sections, int(model.inside.max()), LANES)),
        held=np.zeros(LANES),
        rows=np.zeros(sections, np.int64),
        speeds=np.zeros((sections + 1, LANES)),
        bits=np.zeros(PARTS * LANES),
        told=np.zeros((2, steps, LANES)),
        asked=np.zeros(steps, np.int64),
        rests=np.zeros(LANES, np.int64),
        sticks=np.zeros(LANES),
    )


def most_abreast(model: Model) -> int:
    """So many ticks may wait for their marches: until the first is scored, and the law learned from it.

    One where a march is spread over ticks.
    """
    if not COMPILED or model.shares > 1:
        return 1
    return min(LANES, model.lag + model.now // model.steps)


@inlined
def set_out(model: Model, state: State, room: Room, lane: int) -> None:
    """Keep what the march of this tick sets out from."""
    trips, kept = model.line.round_trip, room.kept[lane]
    for i in range(trips.shape[0]):
        ring = state.waves[0, i]
        mask = mask_of(ring.shape[0])
        first = (state.ticks[0] + 1) * model.steps - trips[i] & mask
        run = min(trips[i], mask + 1 - first)
        _copy(ring[first : first + run], kept[:run])
        _copy(ring[: trips[i] - run], kept[run:])
        kept = kept[trips[i] :]
    for junction in range(room.speeds.shape[0]):
        room.speeds[junction, lane] = state.junctions[0, junction]
    load = load_in_force(state.learned, model.bit_rate)
    set_out_bit(model.line, load, model.bit_rate, room.bits, lane)
    room.bits[SPEED + lane] = state.junctions[0, -1]
    room.bits[BALANCE + lane] = state.balances[0, BIT]
    room.bits[EXTERNAL + lane] = state.rock[0] * model.fade


@inlined
def _copy(source: Floats, to: Floats) -> None:
    for k in range(source.shape[0]):
        to[k] = source[k]


@inlined
def ask(room: Room, steps: int) -> None:
    """Ask for the torques after so many steps: most are never told of, and need not be worked out."""
    room.asked[steps - 1] = 1


@inlined
def march_abreast(model: Model, room: Room, steps: int) -> None:
    """March all lanes for so many steps; the torques of those that are `asked` for are told."""
    line, rows = model.line, room.rows
    trips = line.round_trip
    last = trips.shape[0] - 1
    _lay(line, room)
    # No wave that is sent down in a block of so many steps is back in it: it goes from the bit to the top.
    length = _shortest(trips)
    for first in range(0, steps, length):
        run = min(length, steps - first)
        for step in range(first, first + run):
            arriving = room.waves[last, _row(rows[last], step - first, trips[last])]
            turn_bits(line, model.bit_rate, arriving, room.bits)
            if room.asked[step]:
                tell_torques(arriving, room.bits, room.told[1, step])
            move_bits(line, model.bit_rate, model.fade, arriving, room.bits, room.told[0, step])
        matters = steps - first - trips[last]
        for i in range(last - 1, -1, -1):
            if i < 0 or matters <= 0:
                break
            _pass_junction(line, i, room.waves, rows, min(run, matters), room.speeds[i + 1])
            matters -= trips[i]
        for k in range(run):
            _copy(room.held, room.waves[0, _row(rows[0], k, trips[0])])
        for i in range(last + 1):
            rows[i] = _row(rows[i], run, trips[i])
    room.asked[:] = 0
    if steps >= reach(model, HORIZONS):
        _see_sticks(model, room)


@inlined
def _shortest(trips: Integers) -> int:
    length = trips[0]
    for i in range(trips.shape[0]):
        length = min(length, trips[i])
    return int(length)


@inlined
def _row(first: int, on: int, trip: int) -> int:
    """The row of a section's line so many steps, `trip` at the most, behind the first."""
    row = first + on
    return row if row < trip else row - trip


@inlined
def _lay(line: Line, room: Room) -> None:
    """Lay out what was kept by lanes."""
    before = 0
    for i in range(line.round_trip.shape[0]):
        for row in range(line.round_trip[i]):
            for lane in range(LANES):
                room.waves[i, row, lane] = room.kept[lane, before + row]
        before += line.round_trip[i]
    _copy(room.waves[0, line.round_trip[0] - 1], room.held)
    room.rows[:] = 0


@inlined
def _pass_junction(line: Line, i: int, waves: Floats, rows: Integers, run: int, speeds: Floats) -> None:
    """Pass the waves g of a run of steps, waiting in the section below, through the junction below section i.

    Leaves f in their place, and g as it goes on in the place of the f that arrived.
    """
    z, onward = line.impedance[i], line.impedance[i + 1]
    mobility = 1.0 / (z + onward + line.viscous[i + 1])
    kinetic, static = line.kinetic[i + 1], line.static[i + 1]
    for k in range(run):
        above = waves[i, _row(rows[i], k, line.round_trip[i])]
        below = waves[i + 1, _row(rows[i + 1], k, line.round_trip[i + 1])]
        for lane in range(LANES):
            f, g = above[lane], below[lane]
            # As `load.contact` has it.
            drive = f - g
            turns = abs(drive) > (static if speeds[lane] == 0 else kinetic)
            w = math.copysign(abs(drive) - kinetic, drive) * mobility if turns else 0.0
            speeds[lane] = w
            below[lane] = g + 2 * onward * w
            above[lane] = f - 2 * z * w


@inlined
def _see_sticks(model: Model, room: Room) -> None:
    """Look when each bit is foretold to stick."""
    rests, sticks = room.rests, room.sticks
    rests[:] = 0
    sticks[:] = math.nan
    for step in range(max(0, model.now - model.lasting), reach(model, HORIZONS)):
        speeds, since = room.told[0, step], time_to(model, step + 1 - model.lasting)
        for lane in range(LANES):
            rests[lane] = rests[lane] + 1 if speeds[lane] == 0 else 0
            begins = (rests[lane] == model.lasting) & math.isnan(sticks[lane])
            sticks[lane] = since if begins else sticks[lane]
