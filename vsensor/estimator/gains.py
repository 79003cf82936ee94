"""How much each innovation corrects: Wiener–Kolmogorov gains of the string, worked out once at the start.

The model string runs under the motor's torque. Two unknowns drive the real one away from it: noise of the
torque channel, and what the rock asks beyond the load law, a first-order random process. One output tells
of both: the motor's speed, with noise of its own. With Y the output's answer to each of the two, the
spectrum of what is seen is S = Σ q |Y|² + r = s |H|², H causal and causally invertible (Kolmogorov's
cepstral factorisation, as in Oppenheim and Schafer 2010, ch. 13). Innovations are what is seen divided by
H, and the best correction of any quantity X, n steps after an innovation or before it, is

    k(n) = [ Σ q X Y* / H* ](n) / s          (Kailath 1968; Anderson and Moore 1979, section 9)

This is the steady Kalman filter and its fixed-lag smoother of the whole string, delay lines included,
without a matrix of the size of its state.
"""

import math
from typing import NamedTuple

import numpy as np

from vsensor.estimator.along import Stations, keep_returned
from vsensor.estimator.line import EVERY_JUNCTION, march, turn_top
from vsensor.estimator.load import Load
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.estimator.spectra import Complexes, before, factorised, half_told, rounded
from vsensor.jit import compiled

ROCK_LEVELS: Floats = np.ldexp(25.0, np.arange(9))
"""Standard deviations of the rock's torque, N·m, for which gains are kept ready: 25 N·m to 6.4 kN·m."""
ROCK_MEMORY_S = 0.3
"""Correlation time of the rock's torque: with 0.1 or 1 s instead, the answers are hardly worse."""
MEMORY_S = 30.0
"""The string of the design forgets within so long: one that loses little would ring for minutes."""
HORIZON_S = 4 * MEMORY_S
LEAST_SPEED_NOISE = 1e-4
"""rad/s: a speed without any noise would be believed against all else."""

TOP_SPEED, TOP_BALANCE, BIT_SPEED, BIT_BALANCE, ROCK = range(5)
"""What an innovation corrects of the present state."""
TOLD_BIT_SPEED, TOLD_BIT_TORQUE, TOLD_TOP_SPEED, TOLD_TOP_TORQUE = range(4)
"""What it corrects of the past: the answers."""


class Gains(NamedTuple):
    """Corrections by an innovation of 1 rad/s, for each of C levels of the rock; L steps back in time."""

    levels: Floats
    """The rock's standard deviation, N·m, shape (C,)."""
    innovation: Floats
    """Variance of the innovation, (rad/s)², shape (C,)."""
    state: Floats
    """Of the present state, shape (C, 5)."""
    motor: Floats
    """Of the torque samples that go on to act: the present tick's, and those that are ahead of it because
    torque is told late; shape (C, ⌈late⌉ + 1)."""
    waves: Floats
    """Of the wave f at each section's top, newest first, shape (C, M, L)."""
    returned: Floats
    """Of the wave g there, laid out alike."""
    told: Floats
    """Of the answers, newest first, shape (C, 4, L)."""
    variance: Floats
    """Of the answers' errors once all L corrections are in, (rad/s)² and (N·m)², shape (C, 4)."""
    unforeseen: Floats
    """Of the bit's speed and torque foretold for now and for the end of the forecast, shape (C, 2, 2)."""
    along: Floats
    """Of speed and torque at the string's stations when confirmed, shape (C, 2, n)."""
    band: Floats
    """Frequency up to which at least half of the rock's torque is told, Hz, shape (C,)."""


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


class _Seats(NamedTuple):
    """Where the stations find their waves: those that go down, then those that come back; shapes (2, n)."""

    row: Integers
    """Which internal step of a tick,"""
    late: Integers
    """and how many ticks before the bit's."""


class _Responses(NamedTuple):
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


def gains(plant: Plant, at: Stations, lag: int, ahead: tuple[float, float]) -> Gains:
    """The gains of a string for answers `lag` ticks late, and foretold so many ticks ahead."""
    ticks = 1 << (round(HORIZON_S * plant.rate) - 1).bit_length()
    of_rock, of_noise = (_responses(plant, at, ticks, by_rock=by_rock) for by_rock in (True, False))
    each = [_at_level(plant, at, of_rock, of_noise, float(level), lag, ahead) for level in ROCK_LEVELS]
    of = Gains(ROCK_LEVELS.copy(), *(np.array(column) for column in zip(*each, strict=True)))
    # Rows of several quantities, each of its own unit, are rounded by the levels of each.
    return Gains(
        levels=of.levels,
        innovation=rounded(of.innovation, by_itself=True),
        state=rounded(of.state.T).T.copy(),
        motor=rounded(of.motor),
        waves=rounded(of.waves),
        returned=rounded(of.returned),
        told=rounded(of.told),
        variance=rounded(of.variance.T).T.copy(),
        unforeseen=rounded(of.unforeseen.T).T.copy(),
        along=rounded(of.along),
        band=rounded(of.band, by_itself=True),
    )


def _at_level(
    plant: Plant,
    at: Stations,
    of_rock: _Responses,
    of_noise: _Responses,
    level: float,
    lag: int,
    ahead: tuple[float, float],
) -> tuple[float, Floats, Floats, Floats, Floats, Floats, Floats, Floats, Floats, float]:
    kick = level**2 * (1 - rock_fade(plant.rate) ** 2)
    noise = plant.torque_noise**2
    ticks = 2 * (len(of_rock.seen) - 1)
    speed_noise = max(plant.speed_noise, LEAST_SPEED_NOISE)
    by_rock = kick * np.abs(of_rock.seen) ** 2
    seen = by_rock + noise * np.abs(of_noise.seen) ** 2 + speed_noise**2
    innovation, causal = factorised(seen)
    tells_rock, tells_motor = (
        share * of.seen.conj() / (causal.conj() * innovation)
        for share, of in ((kick, of_rock), (noise, of_noise))
    )

    def respond(rock: Complexes, motor: Complexes) -> Floats:
        response: Floats = np.fft.irfft(rock * tells_rock + motor * tells_motor, ticks)
        return response

    told = respond(of_rock.told, of_noise.told)
    # Variances as sums of what no innovation ever tells and of what those tell that are still to come: the
    # difference of what is and what is told is lost in the rounding of a string that turns freely.
    rock, motor, squares = of_rock.told[:, -1], of_noise.told[:, -1], told[:, -1] ** 2
    apart = kick * np.abs(rock) ** 2 + noise * np.abs(motor) ** 2
    unlike = kick * noise * np.abs(rock * of_noise.seen - motor * of_rock.seen) ** 2
    never = np.fft.irfft((speed_noise**2 * apart + unlike) / seen, ticks)[:, 0]
    confirmed, *unforeseen = (
        never + innovation * before(squares, when) for when in (1 - lag, *map(round, ahead))
    )
    # One section at a time: at high rates all of them at once are too much for the processor's caches.
    waves = np.empty((*of_rock.waves.shape[:-1], ticks))
    for way, section in np.ndindex(*waves.shape[:2]):
        waves[way, section] = respond(of_rock.waves[way, section], of_noise.waves[way, section])
    down, back = (_newest_first(those, lag) for those in waves)
    told_along = _squares_along(plant, at, np.roll(waves, ticks // 2, axis=-1), ticks // 2 + 1 - lag, ticks)
    along = kick * of_rock.along + noise * of_noise.along - innovation * told_along
    return (
        innovation,
        respond(of_rock.state, of_noise.state)[:, 0],
        respond(of_rock.motor, of_noise.motor)[: math.ceil(plant.late) + 1],
        down,
        back,
        _newest_first(told, lag),
        confirmed,
        np.array(unforeseen)[:, :TOLD_TOP_SPEED],
        np.maximum(along, 0.0),
        half_told(by_rock / seen, plant.rate),
    )


def _newest_first(responses: Floats, lag: int) -> Floats:
    """Responses (…, steps, ticks) at ticks 0, −1, … −lag + 1, their internal steps in one row (…, L)."""
    back = responses[..., ::-1, -np.arange(lag)]
    rows = np.moveaxis(back, -2, -1)
    return np.ascontiguousarray(rows.reshape(*rows.shape[:-2], -1))


def _responses(plant: Plant, at: Stations, ticks: int, *, by_rock: bool) -> _Responses:
    line = plant.line
    free = line._replace(kinetic=np.zeros_like(line.kinetic), static=np.zeros_like(line.static))
    load = Load(plant.drag, 0.0, 0.0, 1.0, plant.bit_rate)
    half = ticks // 2
    sections = len(line.impedance)
    state = np.zeros((half, 5))
    waves = np.zeros((half * plant.steps, 2 * sections))
    told = np.zeros((half * plant.steps, 4))
    fade = rock_fade(plant.rate * plant.steps)
    size = 1 << int(line.round_trip.max() + plant.steps).bit_length()
    rings = np.zeros((2, sections, size))
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
    _strike(free, load, plant.drive_rate, plant.steps, fade, by_rock, pulls, rings, state, waves, told)
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
    return _Responses(
        of_state[TOP_SPEED],
        of_state,
        np.fft.rfft(sample * forgets, ticks),
        np.fft.rfft(of_waves, ticks),
        np.fft.rfft(forgotten(told), ticks),
        _squares_along(plant, at, padded, room, half + room),
    )


def _seats(plant: Plant, at: Stations) -> _Seats:
    travel = int(plant.line.round_trip.sum()) // 2
    step = plant.steps - 1 - travel + np.array([at.down - at.inside, at.down + at.inside])
    return _Seats(step % plant.steps, -(step // plant.steps))


def _squares_along(plant: Plant, at: Stations, waves: Floats, start: int, stop: int) -> Floats:
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
        down[k], both[k], back[k] = f @ f, f @ g, g @ g
    fades = np.exp(-seats.late / (MEMORY_S * plant.rate))
    down, both, back = down * fades[0] ** 2, both * fades[0] * fades[1], back * fades[1] ** 2
    turns = 0.5 / line.impedance[at.section]
    rubbed = turns * (at.above * line.viscous[at.section] - at.below * line.viscous[at.section + 1])
    speed = turns**2 * (down - 2 * both + back)
    torque = (0.5 + rubbed) ** 2 * down + 2 * (0.25 - rubbed**2) * both + (0.5 - rubbed) ** 2 * back
    return np.array([speed, torque])


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
    state: Floats,
    waves: Floats,
    told: Floats,
) -> None:
    """Answers of a string at rest to 1 N·m of rock that fades, or to the motor's `pulls`, N·m a step."""
    ring = rings[0]
    mask = ring.shape[1] - 1
    speeds = np.zeros(line.impedance.shape[0] + 1)
    bit = np.zeros((2, 1))
    top_balance, bit_balance = 0.0, 0.0
    rock = 1.0 if by_rock else 0.0
    for step in range(waves.shape[0]):
        g, bit_balance = march(
            line, load, ring, step - 1, 1, step - 1, EVERY_JUNCTION, rock, 1.0, speeds, bit_balance, bit
        )
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
