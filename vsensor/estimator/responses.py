"""What a string at rest answers to its two unknowns: noise of the motor's torque, and the rock's whims.

Each strikes it once, as an impulse; friction that does not answer in proportion is left out. The spectra of
what follows, at top, bit and all along, are what the gains are made of (gains.py).
"""

import math
from typing import NamedTuple

import numpy as np

from vsensor.estimator.along import Stations, keep_returned
from vsensor.estimator.line import march, turn_top
from vsensor.estimator.load import Load
from vsensor.estimator.ring import length_of, mask_of
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.estimator.spectra import Complexes
from vsensor.jit import compiled

ROCK_MEMORY_S = 0.3
"""Correlation time of the rock's torque: with 0.1 or 1 s instead, the answers are hardly worse."""
MEMORY_S = 30.0
"""The string of the design forgets within so long: one that loses little would ring for minutes."""

TOP_SPEED, TOP_BALANCE, BIT_SPEED, BIT_BALANCE, ROCK = range(5)
"""Of the present state: what answers, and what innovations correct."""
TOLD_BIT_SPEED, TOLD_BIT_TORQUE, TOLD_TOP_SPEED, TOLD_TOP_TORQUE = range(4)
"""Of the past: the answers that are told."""


class Plant(NamedTuple):
    """What gains are for; `steps` internal steps a tick, inertias as 2 J / Δt of a step (trapezoid rule)."""

    line: Line
    drag: float
    """Slope of the load law, N·m·s/rad."""
    bit_rate: float
    drive_rate: float
    steps: int
    rate: float
    """Ticks a second."""
    torque_noise: float
    """Of a sample, at the string's side of the gear, N·m."""
    speed_noise: float
    late: float = 0.0
    """How many ticks a sample of torque is late."""
    static: float = 0.0
    """What the bit withstands at rest by the first guess of the load law, N·m."""


class _Seats(NamedTuple):
    """Where the stations find their waves: those that go down, then those that come back; shapes (2, n)."""

    row: Integers
    """Which internal step of a tick,"""
    late: Integers
    """and how many ticks before the bit's."""


class Responses(NamedTuple):
    """Spectra of the answers to one unknown's unit impulse, at the ticks; F frequencies."""

    seen: Complexes
    """Top speed, shape (F,)."""
    state: Complexes
    """Shape (5, F)."""
    motor: Complexes
    """The sample of torque itself, at its own tick; nothing where the rock is the unknown, shape (F,)."""
    waves: Complexes
    """At the sections' tops, down and back, at each internal step of the tick, shape (2, M, steps, F)."""
    told: Complexes
    """Shape (4, steps, F)."""
    along: Floats
    """Sums of squares of speed and torque at n stations, over all ticks, shape (2, n)."""


def rock_fade(rate: float) -> float:
    """Share of the rock's torque that is left after one step at `rate` (Hz)."""
    return math.exp(-1 / (ROCK_MEMORY_S * rate))


def responses(plant: Plant, at: Stations, ticks: int, *, by_rock: bool) -> Responses:
    """The answers over so many ticks, half of which are recorded, to rock or to torque noise."""
    line = plant.line
    free = line._replace(kinetic=np.zeros_like(line.kinetic), static=np.zeros_like(line.static))
    load = Load(plant.drag, 0.0, 0.0, 1.0, plant.bit_rate)
    half = ticks // 2
    sections = len(line.impedance)
    state = np.zeros((half, 5))
    waves = np.zeros((half * plant.steps, 2 * sections))
    told = np.zeros((half * plant.steps, 4))
    fade = rock_fade(plant.rate * plant.steps)
    rings = np.zeros((2, sections, length_of(line.round_trip.max() + plant.steps)))
    # A sample acts on the tick before it and on the one after, and so much earlier as it is told late.
    own = math.ceil(plant.late)
    pulls = np.maximum(
        0.0, 1 - np.abs((np.arange(half * plant.steps) + 1) / plant.steps - 1 - own + plant.late)
    )
    sample = np.zeros(half)
    if by_rock:
        pulls[:] = 0.0
    else:
        sample[own] = 1.0
    scratch = np.zeros(sections + 1), np.zeros((2, 1))
    outcome = state, waves, told
    _strike(free, load, plant.drive_rate, plant.steps, fade, by_rock, pulls, rings, *scratch, *outcome)
    # Cut off, what is left at the end would ring in the spectra: it fades from the middle on.
    fades = np.minimum(1.0, 2 * np.cos(np.pi / 2 * np.arange(half) / half) ** 2)
    forgets = fades * np.exp(-np.arange(half) / (MEMORY_S * plant.rate))

    def forgotten(columns: Floats) -> Floats:
        """Columns (half · steps, K) as rows of ticks: shape (K, steps, half)."""
        rows = columns.reshape(half, -1, columns.shape[1]).transpose(2, 1, 0)
        return np.ascontiguousarray(rows * forgets, np.float64)

    of_state = np.fft.rfft(forgotten(state), ticks)[:, 0]
    of_waves = forgotten(waves).reshape(2, sections, plant.steps, half)
    room = int(_seats(plant, at).late.max())
    padded = np.pad(of_waves, [(0, 0), (0, 0), (0, 0), (room, 0)])
    return Responses(
        of_state[TOP_SPEED],
        of_state,
        np.fft.rfft(sample * forgets, ticks),
        np.fft.rfft(of_waves, ticks),
        np.fft.rfft(forgotten(told), ticks),
        squares_along(plant, at, padded, room, half + room),
    )


def _seats(plant: Plant, at: Stations) -> _Seats:
    travel = int(plant.line.round_trip.sum()) // 2
    step = plant.steps - 1 - travel + np.array([at.down - at.inside, at.down + at.inside])
    return _Seats(step % plant.steps, -(step // plant.steps))


def squares_along(plant: Plant, at: Stations, waves: Floats, start: int, stop: int) -> Floats:
    """Sums of squares of speed and torque at n stations, each seen when the bit of the same moment is.

    `waves` (2, M, steps, ticks) at the sections' tops; the bit's ticks are those from `start` on, and what
    comes back is to be had until `stop`. Speed and torque are made of two waves each: three sums over
    their products tell both. Shape (2, n).
    """
    line, seats = plant.line, _seats(plant, at)
    down, both, back = np.empty((3, len(at.section)))
    for k, section in enumerate(at.section):
        (of_f, of_g), (f_late, g_late) = seats.row[:, k], seats.late[:, k]
        f = waves[0, section, of_f, start - f_late : stop - f_late + g_late]
        g = waves[1, section, of_g, start - g_late : stop]
        down[k], both[k], back[k] = _product(f, f), _product(f, g), _product(g, g)
    fades = np.exp(-seats.late / (MEMORY_S * plant.rate))
    down, both, back = down * fades[0] ** 2, both * fades[0] * fades[1], back * fades[1] ** 2
    turns = 0.5 / line.impedance[at.section]
    rubbed = turns * (at.above * line.viscous[at.section] - at.below * line.viscous[at.section + 1])
    speed = turns**2 * (down - 2 * both + back)
    torque = (0.5 + rubbed) ** 2 * down + 2 * (0.25 - rubbed**2) * both + (0.5 - rubbed) ** 2 * back
    return np.array([speed, torque])


def _product(one: Floats, other: Floats) -> float:
    """Sum of products. `one @ other` is work for several threads of BLAS, which wait in vain for one another
    where the processors are busy."""
    return float(np.einsum("i,i", one, other))


@compiled
def _strike(
    line: Line,
    load: Load,
    drive_rate: float,
    steps: int,
    fade: float,
    by_rock: bool,
    pulls: Floats,
    rings: Floats,
    speeds: Floats,
    bit: Floats,
    state: Floats,
    waves: Floats,
    told: Floats,
) -> None:
    """Answers of a string at rest to 1 N·m of rock that fades, or to the motor's `pulls`, N·m a step.

    `rings` (2, M, size), `speeds` (M + 1,) and `bit` (2, 1) are room for it, all zero.
    """
    ring = rings[0]
    mask = mask_of(ring.shape[1])
    top_balance, bit_balance = 0.0, 0.0
    rock = 1.0 if by_rock else 0.0
    for step in range(waves.shape[0]):
        g, bit_balance = march(line, load, ring, step, rock, speeds, bit_balance, bit, 0)
        w, top_balance = turn_top(line, drive_rate, pulls[step] - g, speeds[0], top_balance)
        speeds[0] = w
        ring[0, step & mask] = g + 2 * line.impedance[0] * w
        keep_returned(line, ring, speeds, step, rings[1])
        for way in range(2):
            for i in range(ring.shape[0]):
                waves[step, way * ring.shape[0] + i] = rings[way, i, step & mask]
        told[step, TOLD_BIT_SPEED] = bit[0, 0]
        told[step, TOLD_BIT_TORQUE] = bit[1, 0]
        told[step, TOLD_TOP_SPEED] = w
        told[step, TOLD_TOP_TORQUE] = g + (line.impedance[0] + line.viscous[0]) * w
        if (step + 1) % steps == 0:
            tick = step // steps
            state[tick, TOP_SPEED] = w
            state[tick, TOP_BALANCE] = top_balance
            state[tick, BIT_SPEED] = bit[0, 0]
            state[tick, BIT_BALANCE] = bit_balance
            state[tick, ROCK] = rock
        rock *= fade
