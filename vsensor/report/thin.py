"""Long records made short enough to draw, and honest: nothing that stands out is left out."""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

BINS = 1500
"""More than a page is wide in pixels, each bin a least and a greatest."""


def thinned(time: Floats, *values: Floats, bins: int = BINS) -> tuple[Floats, tuple[Floats, ...]]:
    """Time and values at the least and greatest of each of `bins` stretches, in their order; all where few.

    One time for all values: of each stretch its first and its last, least and greatest at them in the
    order in which they came. NaN only where a stretch has nothing else.
    """
    count = len(time)
    if count <= 2 * bins:
        return time, values
    width = -(-count // bins)
    whole = count // width * width
    starts = np.arange(0, count, width)
    ends = np.minimum(starts + width, count) - 1
    at = np.column_stack((time[starts], time[ends])).ravel()
    return at, tuple(_extremes(value, width, whole) for value in values)


def _extremes(values: Floats, width: int, whole: int) -> Floats:
    blocks = [values[:whole].reshape(-1, width)]
    if whole < len(values):
        blocks.append(values[None, whole:])
    pairs = [_pairs(block) for block in blocks]
    return np.concatenate(pairs).ravel()


def _pairs(block: Floats) -> Floats:
    """Least and greatest of each row, in the order in which they stand there."""
    known = np.isfinite(block)
    least = np.where(known, block, np.inf).argmin(axis=1)
    greatest = np.where(known, block, -np.inf).argmax(axis=1)
    order = np.sort(np.column_stack((least, greatest)), axis=1)
    return np.asarray(np.take_along_axis(block, order, axis=1))
