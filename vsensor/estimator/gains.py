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
from numpy.typing import NDArray

from vsensor.estimator.along import Stations, keep_returned
from vsensor.estimator.line import EVERY_JUNCTION, march, turn_top
from vsensor.estimator.load import Load
from vsensor.estimator.sections import Floats, Line
from vsensor.jit import compiled

ROCK_LEVELS = 25.0 * 2.0 ** np.arange(9)
"""Standard deviations of the rock's torque, N·m, for which gains are kept ready: 25 N·m to 6.4 kN·m."""
ROCK_MEMORY_S = 0.3
"""Correlation time of the rock's torque: with 0.1 or 1 s instead, the answers are hardly worse."""
MEMORY_S = 5.0
"""The string of the design forgets within so long: one that loses little would ring for minutes."""
HORIZON_S = 8 * MEMORY_S
"""Half of it is run through: cut off after half as long, gains of restless rock were wrong by a third."""
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


class _Responses(NamedTuple):
    """Spectra of the answers to one unknown's unit impulse, at the ticks; F frequencies."""

    seen: NDArray[np.complex128]
    """Top speed, shape (F,)."""
    state: NDArray[np.complex128]
    """Shape (5, F)."""
    waves: NDArray[np.complex128]
    """At each internal step of the tick, shape (M, steps, F)."""
    returned: NDArray[np.complex128]
    """The same of the waves that come back."""
    told: NDArray[np.complex128]
    """Shape (4, steps, F)."""
    along: NDArray[np.complex128]
    """Speed and torque at n stations, when the bit of the same moment stands at the tick; shape (2 n, F)."""


def rock_fade(rate: float) -> float:
    """Share of the rock's torque that is left after one step at `rate` (Hz)."""
    return math.exp(-1 / (ROCK_MEMORY_S * rate))


def gains(plant: Plant, at: Stations, lag: int, ahead: tuple[float, float]) -> Gains:
    """The gains of a string for answers `lag` ticks late, and foretold so many ticks ahead."""
    ticks = 1 << (round(HORIZON_S * plant.rate) - 1).bit_length()
    of_rock, of_noise = (_responses(plant, at, ticks, by_rock=by_rock) for by_rock in (True, False))
    each = [_at_level(plant, of_rock, of_noise, float(level), lag, ahead) for level in ROCK_LEVELS]
    columns: list[Floats] = [np.array(column) for column in zip(*each, strict=True)]
    names = Gains._fields[1:]
    return Gains(
        np.asarray(ROCK_LEVELS, np.float64).copy(),
        *(_rounded(column, name in ROWS) for name, column in zip(names, columns, strict=True)),
    )


ROWS = ("waves", "returned", "told", "along")
"""Gains whose last axis is of one quantity; elsewhere N·m stand beside rad/s."""


def _rounded(column: Floats, rows: bool) -> Floats:
    """Each number to 26 bits, or of a row to 26 bits of its greatest.

    The last bits of transforms and logarithms differ between processors; a session must come out the
    same on each.
    """
    greatest = np.abs(column)
    if rows:
        greatest = greatest.max(axis=-1, keepdims=True)
    grid = np.ldexp(1.0, np.frexp(greatest)[1] - 26)
    return np.asarray(np.rint(column / grid) * grid, np.float64)


def _at_level(
    plant: Plant,
    of_rock: _Responses,
    of_noise: _Responses,
    level: float,
    lag: int,
    ahead: tuple[float, float],
) -> tuple[float, Floats, Floats, Floats, Floats, Floats, Floats, Floats, float]:
    kick = level**2 * (1 - rock_fade(plant.rate) ** 2)
    noise = plant.torque_noise**2
    ticks = 2 * (len(of_rock.seen) - 1)
    speed_noise = max(plant.speed_noise, LEAST_SPEED_NOISE)
    by_rock = kick * np.abs(of_rock.seen) ** 2
    seen = by_rock + noise * np.abs(of_noise.seen) ** 2 + speed_noise**2
    innovation, causal = factorised(seen)

    def respond(rock: NDArray[np.complex128], motor: NDArray[np.complex128]) -> Floats:
        together = kick * rock * of_rock.seen.conj() + noise * motor * of_noise.seen.conj()
        response: Floats = np.fft.irfft(together / causal.conj(), ticks) / innovation
        return response

    def left(rock: NDArray[np.complex128], motor: NDArray[np.complex128], *starts: int) -> list[Floats]:
        """Variances of what innovations up to so many ticks before, or after, have not told.

        Of what no innovation ever tells, and of what those tell that are still to come: as sums of squares,
        for the difference of what is and what is told is lost in the rounding of a string that turns freely.
        """
        apart = kick * np.abs(rock) ** 2 + noise * np.abs(motor) ** 2
        unlike = kick * noise * np.abs(rock * of_noise.seen - motor * of_rock.seen) ** 2
        never = np.fft.irfft((speed_noise**2 * apart + unlike) / seen, ticks)[..., 0]
        squares = respond(rock, motor) ** 2
        return [never + innovation * _before(squares, start) for start in starts]

    told = respond(of_rock.told, of_noise.told)
    bit_and_top = of_rock.told[:, -1], of_noise.told[:, -1]
    confirmed, *unforeseen = left(*bit_and_top, 1 - lag, *map(round, ahead))
    (along,) = left(of_rock.along, of_noise.along, 1 - lag)
    return (
        innovation,
        respond(of_rock.state, of_noise.state)[:, 0],
        _newest_first(respond(of_rock.waves, of_noise.waves), lag),
        _newest_first(respond(of_rock.returned, of_noise.returned), lag),
        _newest_first(told, lag),
        confirmed,
        np.array(unforeseen)[:, :TOLD_TOP_SPEED],
        along.reshape(2, -1),
        _half_told(by_rock / seen, plant.rate),
    )


def factorised(spectrum: Floats) -> tuple[float, NDArray[np.complex128]]:
    """Innovation variance s and H of a spectrum s |H|²: the causal half of the logarithm's transform."""
    ticks = 2 * (len(spectrum) - 1)
    cepstrum = np.fft.irfft(np.log(spectrum), ticks)
    variance = float(np.exp(cepstrum[0]))
    cepstrum[0] = 0.0
    cepstrum[ticks // 2] *= 0.5
    cepstrum[ticks // 2 + 1 :] = 0.0
    return variance, np.exp(np.fft.rfft(cepstrum, ticks))


def _newest_first(responses: Floats, lag: int) -> Floats:
    """Responses (…, steps, ticks) at ticks 0, −1, … −lag + 1, their internal steps in one row (…, L)."""
    back = responses[..., ::-1, -np.arange(lag)]
    rows = np.moveaxis(back, -2, -1)
    return np.ascontiguousarray(rows.reshape(*rows.shape[:-2], -1))


def _before(squares: Floats, start: int) -> Floats:
    """Sum of squares (…, ticks) before tick `start`: of innovations that are still to come by then."""
    ticks = squares.shape[-1]
    past = squares[..., ticks // 2 : ticks + min(start, 0)].sum(axis=-1)
    return np.asarray(past + squares[..., : max(start, 0)].sum(axis=-1))


def _half_told(share: Floats, rate: float) -> float:
    """The highest frequency below which the rock makes more than half of what is seen, Hz."""
    lost = np.flatnonzero(share[1:] < 0.5)
    first = int(lost[0]) if len(lost) else len(share) - 1
    return first * rate / (2 * (len(share) - 1))


def _responses(plant: Plant, at: Stations, ticks: int, *, by_rock: bool) -> _Responses:
    line = plant.line
    free = line._replace(kinetic=np.zeros_like(line.kinetic), static=np.zeros_like(line.static))
    load = Load(plant.drag, 0.0, 0.0, 1.0, plant.bit_rate)
    half = ticks // 2
    sections = len(line.impedance)
    state = np.zeros((half, 5))
    waves = np.zeros((2, half * plant.steps, sections))
    told = np.zeros((half * plant.steps, 4))
    fade = rock_fade(plant.rate * plant.steps)
    size = 1 << int(line.round_trip.max() + plant.steps).bit_length()
    rings = np.zeros((2, sections, size))
    _strike(free, load, plant.drive_rate, plant.steps, fade, by_rock, rings, state, waves, told)
    forgets = np.exp(-np.arange(half) / (MEMORY_S * plant.rate))

    def spectra(columns: Floats) -> NDArray[np.complex128]:
        """Of columns (half · steps, K): shape (K, steps, F)."""
        by_step = columns.reshape(half, -1, columns.shape[1]).transpose(2, 1, 0)
        return np.fft.rfft(by_step * forgets, ticks)

    of_state = spectra(state)[:, 0]
    return _Responses(
        of_state[TOP_SPEED],
        of_state,
        spectra(waves[0]),
        spectra(waves[1]),
        spectra(told),
        spectra(_along(free, at, waves)[plant.steps - 1 :: plant.steps])[:, 0],
    )


def _along(line: Line, at: Stations, waves: Floats) -> Floats:
    """Speed and torque at the stations, each seen when the bit of the same moment is; shape (steps, 2 n).

    `waves` (2, steps, M): those that go down and those that come back, at the sections' tops.
    """
    travel = int(line.round_trip.sum()) // 2
    step = np.arange(waves.shape[1])[:, None] - travel + at.down
    f = _seen(waves[0], step - at.inside, at.section)
    g = _seen(waves[1], step + at.inside, at.section)
    speed = 0.5 * (f - g) / line.impedance[at.section]
    rubbed = at.above * line.viscous[at.section] - at.below * line.viscous[at.section + 1]
    return np.concatenate([speed, 0.5 * (f + g) + rubbed * speed], axis=1)


def _seen(waves: Floats, step: NDArray[np.int64], section: NDArray[np.int64]) -> Floats:
    """Waves (steps, M) at steps (steps, n), nothing before the first."""
    return np.where(step >= 0, waves[np.maximum(step, 0), section], 0.0)


@compiled
def _strike(
    line: Line,
    load: Load,
    drive_rate: float,
    steps: int,
    fade: float,
    by_rock: bool,
    rings: Floats,
    state: Floats,
    waves: Floats,
    told: Floats,
) -> None:
    """Answers of a string at rest to 1 N·m of rock that fades, or of motor torque at one tick's sample."""
    ring = rings[0]
    mask = ring.shape[1] - 1
    speeds = np.zeros(line.impedance.shape[0] + 1)
    bit = np.zeros((2, 1))
    top_balance, bit_balance = 0.0, 0.0
    rock = 1.0 if by_rock else 0.0
    for step in range(waves.shape[1]):
        g, bit_balance = march(
            line, load, ring, step - 1, 1, step - 1, EVERY_JUNCTION, rock, 1.0, speeds, bit_balance, bit
        )
        # A sample of torque stands for a straight line from the sample before, and to the one after.
        motor = 0.0 if by_rock else max(0.0, 1.0 - abs(step + 1 - steps) / steps)
        w, top_balance = turn_top(line, drive_rate, motor - g, speeds[0], top_balance)
        speeds[0] = w
        ring[0, step & mask] = g + 2 * line.impedance[0] * w
        keep_returned(line, ring, speeds, step, rings[1])
        for way in range(2):
            for i in range(ring.shape[0]):
                waves[way, step, i] = rings[way, i, step & mask]
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
