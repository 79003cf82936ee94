"""From motor torque and speed to torque and speed at the string's top, band-limited, at a stated lag.

String torque is gear · efficiency · motor torque − J dω/dt. Its derivative needs a band limit, and
both channels must be delayed alike, so both go through one symmetric kernel: that of the cubic
smoothing spline (Silverman 1984, eq. 2.1), which is what the best estimate of a randomly driven
double integrator in white noise looks like. Its response is 1 / (1 + (f/f_c)⁴), without any phase.
"""

import math
from typing import NamedTuple

import numpy as np

from vsensor.config import TopDrive
from vsensor.estimator.sections import Floats
from vsensor.jit import compiled

REACH = 5.0
"""Where the kernel is cut off, in lengths of its decay: it has fallen to e⁻⁵ there."""


class Smoother(NamedTuple):
    """Weights over a window of 2 h + 1 ticks, newest last, one row for each internal step of a tick."""

    torque_of_torque: Floats
    torque_of_speed: Floats
    speed_of_speed: Floats


def half_width(bandwidth_hz: float, rate_hz: float) -> int:
    """The lag h of the smoother in ticks."""
    return math.ceil(REACH / _decay(bandwidth_hz) * rate_hz)


def _decay(bandwidth_hz: float) -> float:
    return math.sqrt(2) * math.pi * bandwidth_hz


def smoother(drive: TopDrive, bandwidth_hz: float, rate_hz: float, steps: int) -> Smoother:
    """The weights for a top drive: row r gives the estimate h ticks − (steps − 1 − r) internal steps ago.

    Shapes (steps, 2 h + 1). Constants and ramps pass exactly.
    """
    half = half_width(bandwidth_hz, rate_hz)
    ago = (steps - 1 - np.arange(steps)) / steps / rate_hz
    offsets = np.arange(-half, half + 1) / rate_hz + ago[:, None]
    value, slope = _kernels(offsets, _decay(bandwidth_hz))
    turns = drive.gear_ratio
    # The converter reports torque late by its own lag: first order, undone by as much of the slope.
    of_torque = turns * drive.efficiency * (value + drive.torque_lag * slope)
    return Smoother(of_torque, drive.inertia / turns * slope, value / turns)


def _kernels(offsets: Floats, decay: float) -> tuple[Floats, Floats]:
    """Weights for value and slope at 0 of samples at `offsets` (s), each row made exact for ramps."""
    fade = np.exp(-decay * np.abs(offsets))
    value = fade * (np.cos(decay * offsets) + np.sin(decay * np.abs(offsets)))
    slope = fade * np.sin(decay * offsets)
    return _exact(value, value, offsets, 1.0, 0.0), _exact(slope, fade, offsets, 0.0, 1.0)


def _exact(weights: Floats, basis: Floats, offsets: Floats, moment0: float, moment1: float) -> Floats:
    """Scale weights, and add basis · (a + b t), so that Σw and Σwt are as wanted."""
    reached = weights.sum(axis=1) if moment0 else (weights * offsets).sum(axis=1)
    weights = weights / reached[:, None]
    m0, m1, m2 = (np.sum(basis * offsets**n, axis=1) for n in range(3))
    miss0 = moment0 - weights.sum(axis=1)
    miss1 = moment1 - (weights * offsets).sum(axis=1)
    det = m0 * m2 - m1**2
    a = (m2 * miss0 - m1 * miss1) / det
    b = (m0 * miss1 - m1 * miss0) / det
    return np.asarray(weights + basis * (a[:, None] + b[:, None] * offsets))


@compiled
def string_torque(smooth: Smoother, row: int, torque: Floats) -> float:
    """Torque that the motor passes on, N·m, from a window of 2 h + 1 motor torques."""
    return _weighed(smooth.torque_of_torque, row, torque)


@compiled
def turning_torque(smooth: Smoother, row: int, speed: Floats) -> float:
    """Torque that turns the top drive's own inertia, J dω/dt, N·m, from a window of 2 h + 1 motor speeds."""
    return _weighed(smooth.torque_of_speed, row, speed)


@compiled
def string_speed(smooth: Smoother, row: int, speed: Floats) -> float:
    """Speed of the string's top, rad/s, from a window of 2 h + 1 motor speeds."""
    return _weighed(smooth.speed_of_speed, row, speed)


@compiled
def _weighed(weights: Floats, row: int, window: Floats) -> float:
    total = 0.0
    for j in range(weights.shape[1]):
        total += weights[row, j] * window[j]
    return total
