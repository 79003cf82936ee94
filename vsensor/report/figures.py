"""What a session comes to in figures: between what each quantity was, and how long the bit stood."""

from typing import NamedTuple

import numpy as np

from vsensor.grid import NS
from vsensor.report.ticks import BIT, TOP, Floats, Ticks, Times

STUCK = 0.5
"""A bit below this (rad/s, 5 rpm) stands,"""
TURNING = 1.0
"""while a top above this (rad/s, 10 rpm) turns."""


class Extent:
    """Least, greatest and mean of what is known of a quantity; NaN where nothing is."""

    def __init__(self) -> None:
        self.least = self.greatest = np.nan
        self._total, self._count = 0.0, 0

    @property
    def mean(self) -> float:
        """The mean of all values that are known."""
        return self._total / self._count if self._count else np.nan

    def add(self, values: Floats) -> None:
        """Add n values."""
        known = values[np.isfinite(values)]
        if len(known):
            self.least = float(np.fmin(self.least, known.min()))
            self.greatest = float(np.fmax(self.greatest, known.max()))
            self._total += float(known.sum())
            self._count += len(known)


class Sticking(NamedTuple):
    """How long the bit stood while the top turned."""

    share: float
    """Of the time in which the top turned; NaN where it never did."""
    times: int
    longest_s: float


class Stands:
    """How long, and how often, the bit stood below 0.5 rad/s while the top turned at 1 rad/s or more."""

    def __init__(self) -> None:
        self._stuck = self._known = self._times = 0
        self._longest_ns = 0
        self._since: Times = np.empty(0, np.int64)
        """Since when it has been standing; empty where it is not."""

    def add(self, ticks: Ticks) -> None:
        """Add ticks, which come in the order of time."""
        bit, top = np.abs(ticks[BIT]), np.abs(ticks[TOP])
        turning = top >= TURNING
        stuck = turning & (bit < STUCK)
        self._stuck += int(stuck.sum())
        self._known += int((turning & np.isfinite(bit)).sum())
        standing = len(self._since)
        time_ns = np.concatenate((self._since, ticks.time_ns))
        stuck = np.concatenate((np.ones(standing, np.bool_), stuck))
        edges = np.flatnonzero(np.diff(stuck.astype(np.int8), prepend=0, append=0))
        begins, ends = edges[::2], edges[1::2]
        self._times += len(begins) - standing
        self._longest_ns = int((time_ns[ends - 1] - time_ns[begins]).max(initial=self._longest_ns))
        still = len(ends) > 0 and ends[-1] == len(stuck)
        self._since = time_ns[begins[-1:]] if still else time_ns[:0]

    def told(self) -> Sticking:
        """What it came to until now."""
        share = self._stuck / self._known if self._known else float("nan")
        return Sticking(share, self._times, self._longest_ns / NS)
