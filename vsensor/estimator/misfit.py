"""Delay and impedance of the string, told by whose innovations are smallest: the model's or its shadows'.

A parabola through the sums of squares with more of a parameter, with what is in force and with less tells
where it lies and how surely (maximum likelihood, Ljung 1999, chapter 7). Longer delays look much like a lower
impedance: so both are found at once, with what the pairs of shadows differ by together.
"""

import math
from typing import NamedTuple

import numpy as np

from vsensor.estimator.sections import Floats
from vsensor.estimator.tune import (
    DELAY,
    HEARD,
    IMPEDANCE,
    SURELY,
    Matrix,
    Tuning,
    bounded,
    posterior,
    shadows,
)

MEMORY_S = 300.0
"""Time over which the record is forgotten."""
WORTH = 0.05
"""The model is not the string: what innovations tell of it counts for a twentieth,"""
BIAS = (0.001, 0.007)
"""and is no better than this, one deviation, however long the record: where friction, inertia or law were
wrong by what is usual, the likeliest delay of simulated records was off by up to a thousandth, the likeliest
impedance by six (rms)."""
FLOOR = 0.02
"""A valley has a floor where innovations with more and with less are worse by such a share. With a delay that
was wrong by a sixth what looked like one was 1.1 % deep at the most."""
ALIKE = 0.8
"""They are taken to look no more alike than by such a correlation: that of simulated stick-slip."""
SETTLED_S = 60.0
"""No correction before the load law was learned for as long as it remembers: its errors would be laid to the
string."""


class Valley(NamedTuple):
    """The sums of squares about a parameter, as a parabola."""

    information: float
    pull: float
    floor: bool
    """Whether they clearly grow to either side. A valley's side tells the way, not how far."""


def correct_by_misfit(tuning: Tuning, off: Floats, enabled: bool) -> bool:
    """Take up corrections that are due; whether there were any. `off`, shape (3,): the shadows' shares."""
    valleys = [_valley(tuning, p, float(off[p])) for p in (DELAY, IMPEDANCE)]
    together = all(valley.floor for valley in valleys)
    one, other = (valley.information for valley in valleys)
    crossed = _crossed(tuning, off, ALIKE * math.sqrt(one * other)) if together else 0.0
    covariance = posterior(tuning.prior[HEARD].tolist(), [[one, crossed], [crossed, other]])
    dues = _dues(tuning, valleys, covariance, together)
    known = [covariance[p][p] + BIAS[p] ** 2 for p in (DELAY, IMPEDANCE)]
    for p, valley in enumerate(valleys):
        # Only a valley whose floor was seen tells how surely.
        tuning.variance[p] = min(known[p] if valley.floor else math.inf, float(tuning.prior[p]))
    if not enabled or all(due * due <= SURELY**2 * of for due, of in zip(dues, known, strict=True)):
        # What is in force is not what is likeliest: its mean square error holds the difference.
        tuning.variance[HEARD] += np.square(dues)
        return False
    # No further than the shadows were, for there they must look anew.
    tuning.value[HEARD] += np.clip(dues, -off[HEARD], off[HEARD])
    tuning.misfit[:] = 0.0
    tuning.crossed[:] = 0.0
    return True


def _dues(tuning: Tuning, valleys: list[Valley], covariance: Matrix, together: bool) -> list[float]:
    """What is likeliest to be missing of delay and of impedance."""
    dues = [
        bounded(tuning, p, sum(c * valley.pull for c, valley in zip(row, valleys, strict=True)))
        for p, row in enumerate(covariance)
    ]
    if not together:
        # On a slope parabolas do not tell what is whose: one at a time, what makes more difference first.
        worth = [due * valley.pull for due, valley in zip(dues, valleys, strict=True)]
        dues[worth.index(min(worth))] = 0.0
    return dues


def _crossed(tuning: Tuning, off: Floats, most: float) -> float:
    """Information on both at once."""
    crossed = WORTH * float(tuning.crossed[0] / (4 * off[DELAY] * off[IMPEDANCE]))
    return min(max(crossed, -most), most)


def _valley(tuning: Tuning, p: int, off: float) -> Valley:
    here, (more, less) = float(tuning.misfit[0]), tuning.misfit[shadows(p)].tolist()
    information = WORTH * (more - 2 * here + less) / (2 * off * off)
    pull = WORTH * (less - more) / (4 * off)
    # Far from the truth the valley has no floor yet: its side tells the way, and that it is far.
    return Valley(max(information, abs(pull) / (2 * off)), pull, min(more, less) > (1 + FLOOR) * here)
