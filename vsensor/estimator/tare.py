"""Inertia, wall friction and the torque's zero, told by a bit that is off bottom.

It meets nothing there, and what is left over of its torque is theirs. They are parted by what each may be
wrong by, and by what they go with: an inertia with the top drive's acceleration, friction with the wall's
torque, an offset with nothing (linear regression with normal priors, Box and Tiao 1973).
"""

from vsensor.estimator.ring import mask_of
from vsensor.estimator.sections import Floats
from vsensor.estimator.tune import (
    FRICTION,
    INERTIA,
    OFF,
    OFFSET,
    ON,
    SURELY,
    TARED,
    Matrix,
    Tuning,
    bounded,
    posterior,
)
from vsensor.jit import compiled, inlined

MEMORY_S = (30.0, 10.0)
"""Time over which a tare is forgotten, and what bounds friction: that must be heard before it is too late."""
ALIKE = 0.2
"""Friction is bounded by what is the same, but for such a share, twice in a row."""
APART_S = 1.0
"""Bit torques so far apart tell independently of each other."""
RAMP_S = 0.25
"""A shorter string's acceleration is taken over so long to either side."""
_FRICTION, _OFFSET = FRICTION - INERTIA, OFFSET - INERTIA


def correct_by_tare(tuning: Tuning, enabled: bool) -> bool:
    """Take up the corrections that are due; whether there were any.

    All together: what is left of the torque may be surely theirs, and no single one's surely.
    """
    covariance, dues, surely = _due(tuning, OFF)
    taken = [0.0] * len(dues)
    if enabled and surely:
        taken = _take(tuning, dues)
    left = [due - part for due, part in zip(dues, taken, strict=True)]
    for i in range(len(left)):
        tuning.variance[INERTIA + i] = covariance[i][i] + left[i] * left[i]
    tuning.shared[0] = covariance[_FRICTION][_OFFSET] + left[_FRICTION] * left[_OFFSET]
    return any(taken)


def correct_by_bound(tuning: Tuning, enabled: bool) -> bool:
    """Take back what friction surely is too much by, where a bit seems to drive its rock; whether any was.

    No bit does: at the most it meets nothing. An inertia the rock may be taken for, so that is left alone.
    Where friction would have to be less than it can be, it is the torque's reading that is wrong.
    """
    _, (_, friction, offset), surely = _due(tuning, ON)
    tuning.too_low[0] = 0
    if not surely or tuning.pulls[ON, _FRICTION] >= 0.0:
        return False
    asked = float(tuning.pulls[ON, _FRICTION] / tuning.information[ON, _FRICTION, _FRICTION])
    before, tuning.asked[0] = float(tuning.asked[0]), asked
    if abs(asked - before) > ALIKE * abs(asked):  # what it comes to is not to be seen yet
        return False
    if asked < bounded(tuning, FRICTION, asked):
        tuning.too_low[0] = 1
        return False
    if enabled:
        return any(_take(tuning, [0.0, friction, offset]))
    tuning.variance[FRICTION] += friction * friction
    tuning.variance[OFFSET] += offset * offset
    tuning.shared[0] += friction * offset
    return False


def _due(tuning: Tuning, which: int) -> tuple[Matrix, list[float], bool]:
    """Covariance, corrections that are due, and whether they surely are."""
    doubt = 1.0 if which == OFF else float(tuning.doubt[0])
    pulls = (tuning.pulls[which] / doubt).tolist()
    covariance = posterior(tuning.prior[TARED].tolist(), (tuning.information[which] / doubt).tolist())
    dues = [sum(c * pull for c, pull in zip(row, pulls, strict=True)) for row in covariance]
    surely = sum(due * pull for due, pull in zip(dues, pulls, strict=True)) > SURELY**2
    return covariance, dues, surely


def _take(tuning: Tuning, dues: list[float]) -> list[float]:
    """As much of the corrections as leaves all within their bounds."""
    taken = [bounded(tuning, INERTIA + i, due) for i, due in enumerate(dues)]
    tuning.value[TARED] += taken
    # Torques of before the correction are still on their way.
    tuning.pulls[:] = 0.0
    tuning.steady[:] = 0
    return taken


@compiled
def weigh_tare(
    tuning: Tuning, inertial: float, wall: float, torque: float, doubt: float, rate: float
) -> None:
    """Learn from a bit torque that is truly zero, told with the variance `doubt`.

    As configured the top drive's acceleration takes the torque `inertial`, friction the torque `wall`, N·m.
    """
    _weigh(tuning, OFF, inertial, wall, torque, 1.0 / (APART_S * rate * doubt), rate)


@compiled
def weigh_bound(
    tuning: Tuning, inertial: float, wall: float, torque: float, doubt: float, rate: float
) -> None:
    """Learn from one that is zero or more, as seen in the direction in which the string turns."""
    tuning.doubt[0] = doubt
    _weigh(tuning, ON, inertial, wall, torque, 1.0 / (APART_S * rate), rate)


@inlined
def _weigh(
    tuning: Tuning, which: int, inertial: float, wall: float, torque: float, weight: float, rate: float
) -> None:
    keep = 1.0 - 1.0 / (MEMORY_S[which] * rate)
    does = (inertial, wall, 1.0)
    for i in range(3):
        for j in range(3):
            told = tuning.information[which, i, j]
            tuning.information[which, i, j] = keep * told + weight * does[i] * does[j]
        tuning.pulls[which, i] = keep * tuning.pulls[which, i] + weight * does[i] * torque


@compiled
def acceleration(told: Floats, step: int, travel: int, step_s: float) -> float:
    """Of the top (told: its speeds, a ring), about when the bit did what is confirmed of it at `step`.

    A wave from the bit is a travel time underway, and so is one to it: between the two lies the mean.
    """
    half = max(travel, int(RAMP_S / step_s))
    mask = mask_of(told.shape[0])
    return float((told[step & mask] - told[(step - 2 * half) & mask]) / (2 * half * step_s))
