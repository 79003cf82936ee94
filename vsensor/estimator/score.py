"""Predictions held against what is confirmed in the end: how far each kind misses.

The gains tell how large an error rock and noise leave to a prediction, were the model the string. What the
model lacks shows most where the bit changes fast, for there an error of timing is one of speed. So the
square of a miss is held to be a u + b x², u the variance that the gains tell and x the change that was
foretold, and a and b are found by weighted least squares that forget (a variance regression, Davidian and
Carroll 1987). At first a is 1, as the gains have it.
A bit that is foretold to rest mostly does, whatever the rock's whims: the misses of its speed have an a and a
b of their own. With those of a bit that turns they would make these too small.
"""

import math
from typing import NamedTuple

import numpy as np

from vsensor.estimator.sections import Floats, Integers
from vsensor.jit import compiled, inlined

MEMORY_S = 60.0
"""Time over which misses are forgotten: some ten periods of stick-slip."""
HORIZONS = 5
"""Predictions are scored at so many horizons, evenly from now to the end of the forecast."""
NOW, FORECAST = 0, HORIZONS - 1
"""The two of them that are answers."""
VALUE, CHANGE, EXPECTED = range(3)
SPEED, TORQUE, REST = range(3)
"""What has a law of its misses: speed of a bit that is foretold to turn, its torque, speed of one to rest."""
LAWS = 3
TRUST_S = 10.0
"""What the gains tell weighs as much as so much of the record."""
LEAST = 1e-3
"""A variance is never taken to be less than this share of what the gains tell."""
WILD = 25.0
"""A squared miss beyond so many variances, five deviations, counts as one of so many."""


class Scores(NamedTuple):
    """For each of H horizons, of speed and of torque."""

    foretold: Floats
    """What each tick foretold, how fast it changed in a step, and u; a ring, shape (H, 2, 3, ticks);"""
    laws: Floats
    """and for the two answers the laws in force then, NaN before any was scored; (H, ticks, LAWS, 2)."""
    sums: Floats
    """Weighted sums of u², u x², x⁴, u m², m² x²; shape (H, LAWS, 5)."""
    law: Floats
    """a and b, shape (H, LAWS, 2)."""
    misses: Floats
    """Squares of all misses, forgotten at the same pace, and their number so forgotten, shape (H, 2, 2)."""
    scored: Integers
    """Predictions scored so far at each horizon, shape (H,)."""


def fresh_scores(ticks: int, rate: float) -> Scores:
    """Nothing foretold yet; room for `ticks`, of which `rate` make a second."""
    trust = TRUST_S * rate
    return Scores(
        foretold=np.full((HORIZONS, 2, 3, ticks), np.nan),
        laws=np.full((HORIZONS, ticks, LAWS, 2), np.nan),
        sums=np.tile([trust, 0.0, 0.0, trust, 0.0], (HORIZONS, LAWS, 1)),
        law=np.tile([1.0, 0.0], (HORIZONS, LAWS, 1)),
        misses=np.zeros((HORIZONS, 2, 2)),
        scored=np.zeros(HORIZONS, np.int64),
    )


@compiled
def expect(scores: Scores, kind: int, tick: int, unforeseen: Floats, foretold: bool) -> None:
    """Note the variances (2,) that the gains tell of what a tick is about to foretell, if it does."""
    place = tick % scores.foretold.shape[3]
    for q in range(2):
        scores.foretold[kind, q, VALUE, place] = math.nan
        if foretold:
            scores.foretold[kind, q, EXPECTED, place] = unforeseen[q]
    if kind in (NOW, FORECAST):
        for which in range(LAWS):
            for i in range(2):
                law = scores.law[kind, which, i]
                scores.laws[kind, place, which, i] = law if scores.scored[kind] > 0 else math.nan


@compiled
def foretell(scores: Scores, kind: int, quantity: int, tick: int, value: float, change: float) -> None:
    """Note what a march says, and how fast it changes in a step."""
    place = tick % scores.foretold.shape[3]
    scores.foretold[kind, quantity, VALUE, place] = value
    scores.foretold[kind, quantity, CHANGE, place] = change


@compiled
def score(scores: Scores, kind: int, quantity: int, tick: int, truth: float, rate: float) -> None:
    """Hold what `tick` foretold against what was confirmed."""
    place = tick % scores.foretold.shape[3]
    foretold = scores.foretold[kind, quantity, :, place]
    which = _which(scores, kind, quantity, place)
    law = scores.law[kind, which]
    miss = foretold[VALUE] - truth
    x, u = foretold[CHANGE] * foretold[CHANGE], foretold[EXPECTED]
    expected = max(law[0] * u + law[1] * x, LEAST * u)
    # Squares of a normal error scatter in proportion to its variance: their weight is its inverse square.
    weight = 1.0 / (expected * expected)
    m = min(miss * miss, WILD * expected)
    sums = scores.sums[kind, which]
    keep = math.exp(-1.0 / (MEMORY_S * rate))
    for i in range(5):
        sums[i] *= keep
    sums[0] += weight * u * u
    sums[1] += weight * u * x
    sums[2] += weight * x * x
    sums[3] += weight * u * m
    sums[4] += weight * m * x
    misses = scores.misses[kind, quantity]
    misses[0] = keep * misses[0] + miss * miss
    misses[1] = keep * misses[1] + 1.0
    _solve(sums, law)


@inlined
def _solve(sums: Floats, law: Floats) -> None:
    """a and b ≥ 0 of least squares; a alone where the changes tell nothing."""
    determinant = sums[0] * sums[2] - sums[1] * sums[1]
    a = b = 0.0
    if determinant > 1e-9 * sums[0] * sums[2]:
        a = (sums[3] * sums[2] - sums[4] * sums[1]) / determinant
        b = (sums[4] * sums[0] - sums[3] * sums[1]) / determinant
    if b <= 0:
        a, b = sums[3] / sums[0], 0.0
    elif a <= 0:
        a, b = 0.0, sums[4] / sums[2]
    law[0], law[1] = a, b


@compiled
def missed(scores: Scores, kind: int, quantity: int, tick: int) -> float:
    """Expected square of the miss of a tick's answer; NaN where it foretold none, or none was scored yet."""
    place = tick % scores.foretold.shape[3]
    foretold = scores.foretold[kind, quantity, :, place]
    law = scores.laws[kind, place, _which(scores, kind, quantity, place)]
    if math.isnan(foretold[VALUE]):
        return math.nan
    return float(law[0] * foretold[EXPECTED] + law[1] * foretold[CHANGE] * foretold[CHANGE])


@inlined
def _which(scores: Scores, kind: int, quantity: int, place: int) -> int:
    """The law of its misses."""
    return REST if quantity == SPEED and scores.foretold[kind, SPEED, VALUE, place] == 0 else quantity
