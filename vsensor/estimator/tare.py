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
from vsensor.jit import compiled

MEMORY_S = 30.0
"""Time over which a tare is forgotten."""
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
    """
    _, (_, friction, offset), surely = _due(tuning, ON)
    if not surely or tuning.pulls[ON, _FRICTION] >= 0.0:
        return False
    if enabled:
        return any(_take(tuning, [0.0, friction, offset]))
    tuning.variance[FRICTION] += friction * friction
    tuning.variance[OFFSET] += offset * offset
    tuning.shared[0] += friction * offset
    return False


def _due(tuning: Tuning, which: int) -> tuple[Matrix, list[float], bool]:
    """Covariance, corrections that are due, and whether they surely are."""
    pulls = tuning.pulls[which].tolist()
    covariance = posterior(tuning.prior[TARED].tolist(), tuning.information[which].tolist())
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
    tuning: Tuning, which: int, inertial: float, wall: float, torque: float, doubt: float, rate: float
) -> None:
    """Learn from a bit torque that is truly zero, told with the variance `doubt`.

    As configured the top drive's acceleration takes the torque `inertial`, friction the torque `wall`, N·m.
    """
    weight = 1.0 / (APART_S * rate * doubt)
    keep = 1.0 - 1.0 / (MEMORY_S * rate)
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
