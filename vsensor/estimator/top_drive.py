"""From motor torque and speed to torque and speed at the string's top, with their noise, at any lag.

The string's torque T is what the motor's leaves over: J dω/dt = T_motor − T. Both channels are noisy and
T is unknown, so T is held to be a random walk, as strong as the band asks for, and estimated with
ω by a Kalman filter and its fixed-lag smoother (Anderson and Moore 1979, section 7.3). In the steady
state the answer at each lag is a weighted sum of the samples, and the weights are all that the kernels
need: a window finite, exact and equal for every tick. At a long lag the response is 1 / (1 + (f/f_c)⁴)
where the inertia's share of the noise, J 2πf σ_ω, outweighs σ_T, and 1 / (1 + (f/f_c)²) where it does not.
"""

import math
from typing import NamedTuple

import numpy as np

from vsensor.config import Measurement, TopDrive
from vsensor.estimator.sections import Floats
from vsensor.jit import compiled

LAG = 0.9
"""The smoother's lag in periods of the band's end: what comes later changes the answer by less than 2 %."""
REACH = 2.6
"""How far back the weights reach beyond the lag, in the same periods: they have fallen to 1e-5 there."""
PROVISIONAL_S = 0.01
"""Spacing of the provisional answers between the lag and the newest sample."""


class Smoother(NamedTuple):
    """Weights over a window of samples, newest last, one row for each answer; shape (rows, W)."""

    torque_of_torque: Floats
    torque_of_speed: Floats
    speed_of_torque: Floats
    speed_of_speed: Floats


class Smoothers(NamedTuple):
    """The answers asked for at each tick."""

    confirmed: Smoother
    """One for each internal step of the tick that lies `lag` ticks back."""
    provisional: Smoother
    """From there on to the newest sample, one each `stride` ticks."""
    stride: int
    lag: int


def smoothers(
    drive: TopDrive, noise: Measurement, bandwidth_hz: float, rate_hz: float, steps: int
) -> Smoothers:
    """The weights for a top drive, a bandwidth (Hz) and `steps` internal steps in a tick."""
    stride = max(1, round(PROVISIONAL_S * rate_hz))
    lag = stride * math.ceil(LAG / bandwidth_hz * rate_hz / stride)
    window = lag + math.ceil(REACH / bandwidth_hz * rate_hz)
    by_lag = _weights(drive, noise, bandwidth_hz, rate_hz, lag + 1, window)
    share = ((1 + np.arange(steps)) / steps)[:, None]
    between = [share * rows[lag] + (1 - share) * rows[lag + 1] for rows in by_lag]
    later = [np.ascontiguousarray(rows[lag - stride :: -stride]) for rows in by_lag]
    return Smoothers(Smoother(*between), Smoother(*later), stride, lag)


class _Walk(NamedTuple):
    """x = A x + B u, y = C x + noise, in its steady state: gain K, prediction's covariance P."""

    a: Floats
    b: Floats
    gain: Floats
    covariance: Floats
    innovation: float
    closed: Floats
    """A (I − K C): from one prediction to the next."""


def _weights(
    drive: TopDrive, noise: Measurement, bandwidth: float, rate: float, lags: int, window: int
) -> tuple[Floats, Floats, Floats, Floats]:
    """String torque of motor torque and speed, string speed of both, at each lag; (lags + 1, W) each."""
    turns, passed = drive.gear_ratio, drive.gear_ratio * drive.efficiency
    late = drive.torque_lag * rate
    if drive.inertia > 0:
        (speed_of_torque, torque_of_torque), (speed_of_speed, torque_of_speed) = _smoothed(
            _steady(drive, noise, bandwidth, rate), lags, window
        )
        return (
            _earlier(torque_of_torque, late) * passed,
            torque_of_speed / turns,
            _earlier(speed_of_torque, late) * passed,
            speed_of_speed / turns,
        )
    # Nothing turns but the string: each channel is smoothed by itself.
    alone = _smoothed(_plain(bandwidth, rate), lags, window)[1][0]
    nothing = np.zeros_like(alone)
    return _earlier(alone, late) * passed, nothing, nothing, alone / turns


def _steady(drive: TopDrive, noise: Measurement, bandwidth: float, rate: float) -> _Walk:
    """ω and T of the top drive; T walks so strongly that at the band's end it equals the noise."""
    dt, omega = 1 / rate, 2 * math.pi * bandwidth
    of_torque = (noise.torque_noise * drive.gear_ratio * drive.efficiency) ** 2
    of_speed = (max(noise.speed_noise, 1e-6) / drive.gear_ratio) ** 2
    strength = dt * (of_torque + (drive.inertia * omega) ** 2 * of_speed) * omega**2
    gained = dt / drive.inertia
    a = np.array([[1.0, -gained], [0.0, 1.0]])
    b = np.array([gained, 0.0])
    walked = strength * dt * np.array([[gained**2 / 3, -gained / 2], [-gained / 2, 1.0]])
    return _settled(a, b, walked + of_torque * np.outer(b, b), of_speed)


def _plain(bandwidth: float, rate: float) -> _Walk:
    """A value that walks as strongly as its noise at the band's end."""
    strength = (2 * math.pi * bandwidth / rate) ** 2
    return _settled(np.eye(1), np.zeros(1), np.array([[strength]]), 1.0)


def _settled(a: Floats, b: Floats, walked: Floats, noise: float) -> _Walk:
    """Run the Riccati equation by doubling (Anderson 1978) until it has settled; y is the first state."""
    size = len(a)
    observed = np.zeros((size, size))
    observed[0, 0] = 1 / noise
    f, g, p = a.T.copy(), observed, walked.copy()
    for _ in range(60):
        w = np.linalg.inv(np.eye(size) + g @ p)
        f, g, p, before = f @ w @ f, g + f @ w @ g @ f.T, p + f.T @ p @ w @ f, p
        if np.allclose(p, before, rtol=1e-13, atol=0):
            break
    innovation = p[0, 0] + noise
    gain = p[:, 0] / innovation
    seen = np.zeros((size, size))
    seen[:, 0] = gain
    return _Walk(a, b, gain, p, float(innovation), a @ (np.eye(size) - seen))


def _smoothed(walk: _Walk, lags: int, window: int) -> tuple[Floats, Floats]:
    """Weights of the inputs u and of the outputs y for each state at each lag; both (states, lags + 1, W).

    A state smoothed is the state predicted and what each innovation from then on adds to it.
    """
    size = len(walk.a)
    predicted = _predicted(walk, lags + window)
    row = np.zeros((2, size, lags + window))  # column W − 1 + s: of the sample s ticks after the answer's
    row[:, :, :window] = predicted[:, :, window - 1 :: -1]
    rows = np.empty((2, size, lags + 1, window))
    adds = walk.covariance[:, 0] / walk.innovation
    carried = np.linalg.solve(walk.covariance, adds)
    for later in range(lags + 1):
        told = -predicted[:, 0, later + window - 1 :: -1]
        told[1, -1] += 1.0
        row[:, :, : later + window] += adds[:, None] * told[:, None, :]
        rows[:, :, later] = row[:, :, later : later + window]
        carried = walk.closed.T @ carried
        adds = walk.covariance @ carried
    return rows[0], rows[1]


def _predicted(walk: _Walk, ticks: int) -> Floats:
    """What a state predicted owes to u and y of 0, 1, … ticks ago, shape (2, states, ticks)."""
    responses = np.empty((2, len(walk.a), ticks))
    responses[:, :, 0] = walk.b / 2, np.zeros_like(walk.b)
    kick = np.stack([walk.closed @ walk.b / 2 + walk.b / 2, walk.a @ walk.gain])
    for ago in range(1, ticks):
        responses[:, :, ago] = kick
        kick = kick @ walk.closed.T
    return responses


def _earlier(weights: Floats, ticks: float) -> Floats:
    """Let each sample stand for a time so many ticks before its own; the newest also for what is newer."""
    whole = math.floor(ticks)
    share = ticks - whole
    shifted = _shifted(weights, whole)
    return (1 - share) * shifted + share * _shifted(shifted, 1)


def _shifted(weights: Floats, ticks: int) -> Floats:
    if ticks == 0:
        return weights
    shifted = np.zeros_like(weights)
    shifted[..., ticks:] = weights[..., :-ticks]
    shifted[..., -1] += weights[..., -ticks:].sum(axis=-1)
    return shifted


@compiled
def string_torque(smooth: Smoother, row: int, torque: Floats) -> float:
    """Torque that the motor passes on, N·m, from a window of motor torques."""
    return _weighed(smooth.torque_of_torque, row, torque)


@compiled
def turning_torque(smooth: Smoother, row: int, speed: Floats) -> float:
    """Torque that turns the top drive's own inertia, J dω/dt, N·m, from a window of motor speeds."""
    return -_weighed(smooth.torque_of_speed, row, speed)


@compiled
def string_speed(smooth: Smoother, row: int, torque: Floats, speed: Floats) -> float:
    """Speed of the string's top, rad/s, from windows of both."""
    return _weighed(smooth.speed_of_torque, row, torque) + _weighed(smooth.speed_of_speed, row, speed)


@compiled
def speed_alone(smooth: Smoother, row: int, speed: Floats) -> float:
    """The same from the speed channel alone."""
    return _weighed(smooth.speed_of_speed, row, speed)


@compiled
def _weighed(weights: Floats, row: int, window: Floats) -> float:
    total = 0.0
    for j in range(weights.shape[1]):
        total += weights[row, j] * window[j]
    return total
