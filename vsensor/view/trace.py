"""One line's rows between two sends, thinned for drawing without losing a peak."""

import math

import numpy as np
from numpy.typing import NDArray

SLOT_NS = 20_000_000
"""Two points in 20 ms are at most 100 a second: 6000 in a minute's plot, which is some 1000 pixels wide."""

HOLE_NS = 3_000_000_000
"""Rows further apart are not joined; the rarest come once a second."""


class Trace:
    """Collects (time, value, standard deviation) and holes: where nothing is known, nothing is drawn."""

    def __init__(self) -> None:
        self._times: list[int] = []
        self._values: list[tuple[float, float]] = []
        self._last_ns: int | None = None

    def add(self, time_ns: int, value: float, deviation: float = math.nan) -> None:
        """Add a row; NaN for a value that is not known (an infinite one is no better)."""
        if not math.isfinite(value):
            self._end()
            return
        if self._last_ns is not None and time_ns - self._last_ns > HOLE_NS:
            self._end()
        self._append(time_ns, value, deviation)
        self._last_ns = time_ns

    def take(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Hand over what has come, thinned: times (rows,), values and their deviations (rows, 2)."""
        times = np.array(self._times, dtype=np.int64)
        values = np.array(self._values, dtype=np.float64).reshape(-1, 2)
        self._times, self._values = [], []
        kept = envelope(times, values[:, 0])
        return times[kept], values[kept]

    def _end(self) -> None:
        """End the line by a row without value just after the last one: Rerun breaks its stroke at NaN."""
        if self._last_ns is not None:
            self._append(self._last_ns + 1, math.nan, math.nan)
        self._last_ns = None

    def _append(self, time_ns: int, value: float, deviation: float) -> None:
        self._times.append(time_ns)
        self._values.append((value, deviation))


def envelope(times_ns: NDArray[np.int64], values: NDArray[np.float64]) -> NDArray[np.intp]:
    """Which rows to draw: of each 20 ms the lowest and the highest, and every hole.

    Every n-th row would be as few, but would show noise as slow waves (aliasing) and lose the one late tick
    that matters. times_ns, values : shape (rows,); returns indices, ascending.
    """
    holes = np.flatnonzero(np.isnan(values))
    rows = np.flatnonzero(~np.isnan(values))
    slots = times_ns[rows] // SLOT_NS
    order = np.lexsort((values[rows], slots))
    changes = np.flatnonzero(np.diff(slots[order])) + 1
    edges = np.concatenate([[0], changes, [order.size]]) if order.size else np.zeros(1, dtype=np.intp)
    lowest, highest = order[edges[:-1]], order[edges[1:] - 1]
    return np.unique(np.concatenate([holes, rows[lowest], rows[highest]]))
