"""How badly the bit sticks and slips."""

import numpy as np

from vsensor.estimator.sections import Floats


def severity(speeds: Floats) -> float:
    """Stick-slip severity (ω_max − ω_min) / (2 ω_mean) of the bit over a window; NaN where it does not turn.

    0 is smooth; from 1 on the bit stops. (The SSI of the drilling literature; definitions differ,
    this is the one printed beside each figure of ours.)
    """
    known = speeds[np.isfinite(speeds)]
    if len(known) == 0 or abs(mean := float(known.mean())) < MOVING:
        return float("nan")
    return float(np.ptp(known)) / (2 * abs(mean))


MOVING = 0.1
"""A mean speed below this (rad/s, 1 rpm) is no rotation."""
