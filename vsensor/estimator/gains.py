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
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vsensor.estimator.along import Stations
from vsensor.estimator.responses import (
    MEMORY_S,
    TOLD_TOP_SPEED,
    Plant,
    Responses,
    responses,
    rock_fade,
    squares_along,
)
from vsensor.estimator.sections import Floats
from vsensor.estimator.spectra import Complexes, before, factorised, half_told, rounded

ROCK_LEVELS: Floats = np.ldexp(12.5, np.arange(10))
"""Standard deviations of the rock's torque, N·m, for which gains of a well's string are kept ready: from
12.5 N·m to 6.4 kN·m."""
HIDDEN = 0.5
"""Rock that is less restless than this share of the noise is not seen,"""
NEGLIGIBLE = 0.005
"""and than this share of what the bit withstands at rest, by the first guess of the law, does not matter."""
HORIZON_S = 4 * MEMORY_S
"""Spectra are of so long a record: half of it answers, and half keeps its end from folding back."""
LEAST_SPEED_NOISE = 1e-4
"""rad/s: a speed without any noise would be believed against all else."""


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
    """Of the wave f at each section's top, newest last, shape (C, M, L)."""
    returned: Floats
    """Of the wave g there, laid out alike."""
    told: Floats
    """Of the answers, newest last, shape (C, 4, L)."""
    variance: Floats
    """Of the answers' errors once all L corrections are in, (rad/s)² and (N·m)², shape (C, 4)."""
    unforeseen: Floats
    """Of the bit's speed and torque foretold for each of H horizons, shape (C, H, 2)."""
    along: Floats
    """Of speed and torque at the string's stations when confirmed, shape (C, 2, n)."""
    traces: Floats
    """How far innovations, else white, hang together over their variance, by ticks apart, where the rock's is
    twice the level's; shape (C, lag)."""
    telling: Floats
    """The sum of their squares, of both signs: what one innovation tells of that, shape (C,)."""
    band: Floats
    """Frequency up to which at least half of the rock's torque is told, Hz, shape (C,)."""


def gains(plant: Plant, at: Stations, lag: int, ahead: Sequence[float]) -> Gains:
    """The gains of a string for answers `lag` ticks late, and foretold so many ticks ahead."""
    ticks = 1 << (round(HORIZON_S * plant.rate) - 1).bit_length()
    of_rock, of_noise = (responses(plant, at, ticks, by_rock=by_rock) for by_rock in (True, False))
    each = [_at_level(plant, at, of_rock, of_noise, float(level), lag, ahead) for level in rock_levels(plant)]
    of = Gains(*(np.array(column) for column in zip(*each, strict=True)))
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
        traces=rounded(of.traces),
        telling=rounded(of.telling, by_itself=True),
        band=rounded(of.band, by_itself=True),
    )


def rock_levels(plant: Plant) -> Floats:
    """Standard deviations of the rock's torque for which gains are kept, N·m, each twice the one before.

    ROCK_LEVELS, and below them, for a rig that is far weaker than a well's, as many as it can tell of.
    """
    noise = math.hypot(plant.torque_noise, plant.line.impedance[0] * _speed_noise(plant))
    least = max(HIDDEN * noise, NEGLIGIBLE * plant.static)
    below = max(0, math.ceil(math.log2(ROCK_LEVELS[0] / least)))
    return np.concatenate([ROCK_LEVELS[0] * 0.5 ** np.arange(below, 0, -1), ROCK_LEVELS])


def _speed_noise(plant: Plant) -> float:
    return max(plant.speed_noise, LEAST_SPEED_NOISE)


def _at_level(
    plant: Plant,
    at: Stations,
    of_rock: Responses,
    of_noise: Responses,
    level: float,
    lag: int,
    ahead: Sequence[float],
) -> Gains:
    """Those of one level, without the first dimension."""
    kick = level**2 * (1 - rock_fade(plant.rate) ** 2)
    noise = plant.torque_noise**2
    ticks = 2 * (len(of_rock.seen) - 1)
    speed_noise = _speed_noise(plant)
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
    down, back = (_newest_last(those, lag) for those in waves)
    traces = np.fft.irfft(by_rock / seen, ticks)[:lag]
    told_along = squares_along(plant, at, np.roll(waves, ticks // 2, axis=-1), ticks // 2 + 1 - lag, ticks)
    along = kick * of_rock.along + noise * of_noise.along - innovation * told_along
    return Gains(
        levels=np.array(level),
        innovation=np.array(innovation),
        state=respond(of_rock.state, of_noise.state)[:, 0],
        motor=respond(of_rock.motor, of_noise.motor)[: math.ceil(plant.late) + 1],
        waves=down,
        returned=back,
        told=_newest_last(told, lag),
        variance=confirmed,
        unforeseen=np.array(unforeseen)[:, :TOLD_TOP_SPEED],
        along=np.maximum(along, 0.0),
        traces=traces,
        telling=np.array(2 * np.sum(traces**2) - traces[0] ** 2),
        band=np.array(half_told(by_rock / seen, plant.rate)),
    )


def _newest_last(responses: Floats, lag: int) -> Floats:
    """Responses (…, steps, ticks) at ticks −lag + 1 … 0, their internal steps in one row (…, L)."""
    back = responses[..., np.arange(lag) - lag + 1]
    rows = np.moveaxis(back, -2, -1)
    return np.ascontiguousarray(rows.reshape(*rows.shape[:-2], -1))
