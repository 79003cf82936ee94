"""What a value can have become since the last: inertia lets no speed leap.

A link that drops out tells 0, or another number that nobody has measured, and tells it again: each sample
bears the one before out, and taken for a step it would be a blow that no string was ever dealt. A channel
that comes back is believed at once, one that stays where it cannot be after a while: it may be that what was
told before was wrong, or that a drive is no longer what its configuration says.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.grid import NS
from vsensor.saved import Saved

HARDEST = 2.0
"""Motor, brake and string together turn the top by no more than so many times the torque that is believed."""
COARSEST = 0.02
"""No reading has steps, nor noise, so large a part of what is believed of it."""


class Apart(NamedTuple):
    """Samples that cannot follow from what was accepted: the newest of them, and when they began."""

    time_ns: int
    value: float
    since_ns: int


class Reach:
    """Whether one channel's samples can follow each other."""

    def __init__(self, rate: float, limit: float, patience_ns: int) -> None:
        """`rate` is what it can change by in a second (inf: nothing is refused), `limit` what is believed."""
        self._rate = rate
        self._step = COARSEST * limit
        self._patience_ns = patience_ns
        self.apart: Apart | None = None

    def refuses(self, before_ns: int, before: float, time_ns: int, value: float) -> bool:
        """Whether a sample can be none that follows the newest accepted one, `before`."""
        apart = self.apart
        if apart is None:
            if abs(value - before) <= self._step or self._follows(before_ns, before, time_ns, value):
                return False
            self.apart = Apart(time_ns, value, time_ns)
            return True
        if not self._follows(apart.time_ns, apart.value, time_ns, value):
            self.apart = None
            return self.refuses(before_ns, before, time_ns, value)
        self.apart = Apart(time_ns, value, apart.since_ns)
        if time_ns - apart.since_ns <= self._patience_ns:
            return True
        if self._follows(before_ns, before, time_ns, value):
            self.apart = None
        return False

    def _follows(self, before_ns: int, before: float, time_ns: int, value: float) -> bool:
        return abs(value - before) <= self._step + self._rate * (time_ns - before_ns) / NS

    def surely(self, times_ns: NDArray[np.int64], values: NDArray[np.float64]) -> bool:
        """Whether none of n samples, shape (n,), would be refused.

        Nor where a stray is left out: the one behind it lies nearer to the one before than to the stray.
        """
        within = self._step + self._rate * np.diff(times_ns) / NS
        return self.apart is None and bool(np.all(np.abs(np.diff(values)) <= within))

    def save(self) -> list[float] | None:
        """What is remembered, as plain values."""
        return None if self.apart is None else list(self.apart)

    def restore(self, saved: Saved, latest_ns: int) -> None:
        """Take up what `save` gave. Raises ValueError for what it cannot have given."""
        time_ns, value, since_ns = saved.row(3)
        time = time_ns.whole(-latest_ns, latest_ns)
        self.apart = Apart(time, value.number(), since_ns.whole(-latest_ns, time))


def rate_of(torque_limit: float, inertia: float) -> float:
    """How fast a top drive's speed can change, rad/s²."""
    return HARDEST * torque_limit / inertia if inertia else math.inf
