"""Long records made short enough to draw, and honest: nothing that stands out is left out."""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Times = npt.NDArray[np.int64]

BINS = 1500
"""More than a page is wide in pixels, each bin a least and a greatest."""


class Thinned:
    """Columns of values over one time, of each stretch the least and the greatest, in the order they came.

    However many values come, there are no more than twice `bins` stretches: as soon as there are, each
    two become one. So long as a stretch is one value, all are there as they are.
    """

    def __init__(self, columns: int, bins: int = BINS) -> None:
        self._bins = bins
        self._width = 1
        """Values in each stretch;"""
        self._count = 0
        """values so far: the last stretch may lack some."""
        self._times: Times = np.empty((0, 2), np.int64)
        """Of each stretch, its first and its last;"""
        self._pairs: Floats = np.empty((columns, 0, 2))
        """of each column and stretch, the least and the greatest. NaN only where it has nothing else."""

    def add(self, time_ns: Times, *values: Floats) -> None:
        """Add n values of each column, each of shape (n,)."""
        told = np.array(values)
        lacking = min(-self._count % self._width, len(time_ns))
        if lacking:
            times = np.concatenate((self._times[-1], time_ns[:lacking]))
            pair = np.concatenate((self._pairs[:, -1], told[:, :lacking]), axis=1)
            self._times, self._pairs = self._times[:-1], self._pairs[:, :-1]
            self._append(times[None], pair[:, None])
        whole = lacking + (len(time_ns) - lacking) // self._width * self._width
        if whole > lacking:
            self._append(
                time_ns[lacking:whole].reshape(-1, self._width),
                told[:, lacking:whole].reshape(len(told), -1, self._width),
            )
        if whole < len(time_ns):
            self._append(time_ns[None, whole:], told[:, None, whole:])
        self._count += len(time_ns)
        while len(self._times) > 2 * self._bins:
            self._halve()

    def drawn(self) -> tuple[Times, Floats]:
        """Times, shape (m,), and the columns over them, shape (columns, m)."""
        if self._width == 1:
            return self._times[:, 0], self._pairs[:, :, 0]
        return self._times.ravel(), self._pairs.reshape(len(self._pairs), -1)

    def _append(self, times: Times, values: Floats) -> None:
        """Add stretches, of so many times each: shape (stretches, width), with columns before."""
        self._times = np.concatenate((self._times, times[:, [0, -1]]))
        self._pairs = np.concatenate((self._pairs, _pairs(values)), axis=1)

    def _halve(self) -> None:
        times, pairs = self._times, self._pairs
        even = len(times) // 2 * 2
        self._times, self._pairs = times[:0], pairs[:, :0]
        self._append(times[:even].reshape(-1, 4), pairs[:, :even].reshape(len(pairs), -1, 4))
        self._times = np.concatenate((self._times, times[even:]))
        self._pairs = np.concatenate((self._pairs, pairs[:, even:]), axis=1)
        self._width *= 2


def _pairs(values: Floats) -> Floats:
    """Least and greatest along the last axis, in the order in which they stand there."""
    known = np.isfinite(values)
    least = np.where(known, values, np.inf).argmin(axis=-1)
    greatest = np.where(known, values, -np.inf).argmax(axis=-1)
    order = np.sort(np.stack((least, greatest), axis=-1), axis=-1)
    return np.asarray(np.take_along_axis(values, order, axis=-1))
