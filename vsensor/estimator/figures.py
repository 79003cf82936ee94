"""What a driller asks of the last while: period, stuck share, turning back, and where the power goes."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.estimator.sections import Floats
from vsensor.estimator.severity import MOVING

BIT_SPEED, BIT_TORQUE, TOP_SPEED, TOP_TORQUE = range(4)
"""Rows of a window: bit and top of the string at one and the same time, rad/s and N·m, NaN where unknown."""
ROWS = 4

STUCK_SPEED = 0.5
"""A bit slower than this (rad/s, 5 rpm) stands still, or as good as still: three times its noise and more."""
SWING = 0.25
"""A period is counted once the speed has gone from the lowest quarter of its range to the highest."""
IRREGULAR = 0.2
"""Periods that differ by more than this share of their mean (rms) are none."""


class Figures(NamedTuple):
    """Over one window; NaN where not known. Named as the fields of the status."""

    stuck_share: float
    """Share of the time in which the bit stands (below STUCK_SPEED) while the top turns twice as fast."""
    back_rotation_share: float
    """Share of the time in which the bit turns against the top's mean speed, faster than STUCK_SPEED."""
    back_rotation_turns: float
    """How far it turned back in that time, revolutions."""
    top_power_w: float
    """Mean of torque · speed at the string's top: what the top drive feeds in, W."""
    bit_power_w: float
    """Mean of torque · speed of the bit: what reaches the rock, W."""
    lost_power_w: float
    """Their difference, W: lost on the wall and in the mud, and what the string holds more than at first."""


def figures(window: Floats, tick_s: float) -> Figures:
    """Figures of a window, shape (ROWS, n), one column a tick, oldest first."""
    known = window[:, np.isfinite(window).all(axis=0)]
    if known.shape[1] == 0:
        return Figures(*[math.nan] * len(Figures._fields))
    back = _turns_back(known)
    fed = float(np.mean(known[TOP_SPEED] * known[TOP_TORQUE]))
    given = float(np.mean(known[BIT_SPEED] * known[BIT_TORQUE]))
    return Figures(
        stuck_share=float(np.mean(_stands(known))),
        back_rotation_share=float(np.mean(back)),
        back_rotation_turns=float(np.abs(known[BIT_SPEED][back]).sum()) * tick_s / (2 * math.pi),
        top_power_w=fed,
        bit_power_w=given,
        lost_power_w=fed - given,
    )


def period(speeds: Floats, tick_s: float) -> float:
    """Period of stick-slip, s; NaN where the bit sticks too seldom, or irregularly.

    It is the mean time from one release to the next, and from one stop to the next. A release is the
    speed's way from the lowest quarter of its range into the highest, a stop the way back. `speeds` (n,) in
    rad/s, NaN where unknown.
    """
    finite = speeds[np.isfinite(speeds)]
    if len(finite) == 0:
        return math.nan
    low, high = float(finite.min()), float(finite.max())
    margin = SWING * (high - low)
    side = (speeds > high - margin).astype(np.int8) - (speeds < low + margin).astype(np.int8)
    ticks = np.flatnonzero(side)
    turns = np.diff(side[ticks])
    periods = tick_s * np.concatenate([np.diff(ticks[1:][turns > 0]), np.diff(ticks[1:][turns < 0])])
    if len(periods) < 2:
        return math.nan
    mean = float(periods.mean())
    return mean if periods.std() <= IRREGULAR * mean else math.nan


def _stands(known: Floats) -> NDArray[np.bool_]:
    turns = np.abs(known[TOP_SPEED]) >= 2 * STUCK_SPEED
    return np.asarray(turns & (np.abs(known[BIT_SPEED]) < STUCK_SPEED))


def _turns_back(known: Floats) -> NDArray[np.bool_]:
    """When the bit turns against the string; never where the string's top does not turn on the whole."""
    mean = float(known[TOP_SPEED].mean())
    forwards = math.copysign(1.0, mean) if abs(mean) >= MOVING else 0.0
    return np.asarray(known[BIT_SPEED] * forwards < -STUCK_SPEED)
