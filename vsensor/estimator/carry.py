"""A string made longer or shorter at its top while it runs: what is in its lines stays where it is.

Measured from the bit upwards nothing has moved. In slanted time all of it is seen later by what the top
has moved away, Δ: a wave at travel time D below the new top is the one that stood D − Δ below the old, and
is looked up Δ steps earlier. What is new at the top is taken to be as the old top was.
"""

import numpy as np
from numpy.typing import NDArray

from vsensor.estimator.along import catch_up
from vsensor.estimator.responses import TOLD_TOP_SPEED
from vsensor.estimator.ring import mask_of
from vsensor.estimator.sections import Floats, Line
from vsensor.estimator.state import Model, State, heard

KEPT = (
    "inputs",
    "missing",
    "motor",
    "balances",
    "rock",
    "off_bottom",
    "held",
    "slips",
    "innovation",
    "surprise",
    "rock_square",
    "level",
    "steps",
    "resolution",
    "bends",
    "lasts",
    "white",
    "noisier",
    "ticks",
    "last_seen",
)
"""What does not depend on the string's length."""


def carry(old: State, before: Model, new: State, line: Line) -> None:
    """Fill the state of the new string, cut into `line`, with what the old one holds of its own."""
    for name in KEPT:
        getattr(new, name)[...] = getattr(old, name)
    for inner in ("learned", "tuning"):
        for to, kept in zip(getattr(new, inner), getattr(old, inner), strict=True):
            to[...] = kept
    for name in ("sums", "law", "misses", "scored"):
        getattr(new.scores, name)[...] = getattr(old.scores, name)
    last = int(old.ticks[0]) * before.steps - 1
    longer = line.depth[-1] - before.line.depth[-1]
    # What is heard from now on has gains of the new string.
    catch_up(heard(before, old), old.waves[0], old.returned)
    _carry_waves(old, before.line, new, line, last)
    shift = round(longer)
    _copy(old.told[:, :TOLD_TOP_SPEED], new.told[:, :TOLD_TOP_SPEED], last, shift)
    _copy(old.told[:, TOLD_TOP_SPEED:], new.told[:, TOLD_TOP_SPEED:], last, 0)
    for to, kept in zip(new.junctions, old.junctions, strict=True):
        to[:] = np.interp(line.depth - longer, before.line.depth, kept)
        to[-1] = kept[-1]  # at rest is exactly at rest


def _carry_waves(old: State, before: Line, new: State, line: Line, last: int) -> None:
    longer = line.depth[-1] - before.depth[-1]
    for j in range(len(line.impedance)):
        depth = float(line.depth[j] - longer)
        i = max(0, int(np.searchsorted(before.depth, depth + 1e-9, side="right")) - 1)
        below = depth - float(before.depth[i])
        _copy(old.waves[:, i], new.waves[:, j], last, round(longer + 2 * below))
        _copy(old.returned[i], new.returned[j], last, round(longer))


def _copy(old: Floats, new: Floats, last: int, shift: int) -> None:
    """Copy rings (…, size) up to step `last`, each step from `shift` steps earlier, from what is known."""
    there, here = mask_of(old.shape[-1]), mask_of(new.shape[-1])
    steps: NDArray[np.int64] = last - np.arange(min(there, here) + 1)
    known = np.clip(steps - shift, last - there, last)
    new[..., steps & here] = old[..., known & there]
