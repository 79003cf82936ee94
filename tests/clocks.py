"""Two records of one oscillation, each by its own clock: their two periods tell the clocks' ratio."""

import numpy as np
from numpy.typing import NDArray

from tests.cases import Columns

HARMONICS = 3
COARSE_S, FINE_S = 0.02, 5e-4
"""Periods are tried so far apart, then about the best of them: a valley is tenths of a second wide."""
LIKELY_S = np.arange(3.5, 4.5, COARSE_S)
"""Periods of stick-slip that are tried."""
SETTLED_S = 16.0
"""From here on the well's stick-slip is periodic: before, the string starts to turn."""


def period(time: NDArray[np.float64], values: NDArray[np.float64], from_s: float = SETTLED_S) -> float:
    """The period of an oscillation, s: of a few harmonics about a straight line, those that fit best."""
    settled = time >= from_s
    t, x = time[settled], values[settled]

    def missed(seconds: float) -> float:
        phase = 2 * np.pi * t[:, None] * np.arange(1, HARMONICS + 1) / seconds
        waves = np.column_stack([np.ones_like(t), t, np.cos(phase), np.sin(phase)])
        return float(np.sum((x - waves @ np.linalg.lstsq(waves, x, rcond=None)[0]) ** 2))

    best = min(LIKELY_S, key=missed)
    return float(min(np.arange(best - COARSE_S, best + COARSE_S, FINE_S), key=missed))


def clock_rate(surface: Columns, truth: Columns) -> float:
    """Seconds that pass by the surface's clock in one of the downhole sensor's, without any model."""
    middle = (truth["bit_speed_min_rad_s"] + truth["bit_speed_max_rad_s"]) / 2
    above = period(surface["time_s"], surface["motor_torque_nm"])
    return above / period(truth["time_s"], middle)


def set_right(truth: Columns, rate: float) -> Columns:
    """A downhole record by a clock that runs at the surface's rate; the middle of the record stays."""
    time = truth["time_s"]
    centre = (time[0] + time[-1]) / 2
    return {**truth, "time_s": centre + rate * (time - centre)}
