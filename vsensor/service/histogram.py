"""Durations counted in fixed buckets: no allocation while counting, quantiles from differences.

Four buckets to each doubling, as of HdrHistogram: a quantile is told to within an eighth of itself.
"""

from bisect import bisect
from collections.abc import Sequence

from vsensor.grid import NS
from vsensor.messages.vsensor_pb2 import Histogram as HistogramMessage

_FIRST = 10
"""The finest bucket holds all below 2^10 ns, a microsecond;"""
_OCTAVES = 24
"""the last one all beyond 2^34 ns, 17 s."""


def _uppers_ns() -> list[int]:
    octaves = range(_FIRST, _FIRST + _OCTAVES)
    return [1 << _FIRST, *((quarter << octave - 2) for octave in octaves for quarter in (5, 6, 7, 8))]


UPPERS_NS = _uppers_ns()
_UPPERS_S = [upper / NS for upper in UPPERS_NS]
_LAST = len(UPPERS_NS)


class Histogram:
    """Counts since the start, and since the last `turn_over`."""

    def __init__(self) -> None:
        self.counts = [0] * (_LAST + 1)
        self.sum_ns = 0
        self._before = list(self.counts)

    def note(self, ns: int) -> None:
        """Count one duration."""
        self.sum_ns += ns
        self.counts[bisect(UPPERS_NS, ns)] += 1

    def turn_over(self) -> list[int]:
        """The counts since the last call."""
        since = [now - before for now, before in zip(self.counts, self._before, strict=True)]
        self._before = list(self.counts)
        return since

    def message(self) -> HistogramMessage:
        """As it is published."""
        return HistogramMessage(upper_s=_UPPERS_S, counts=self.counts, sum_s=self.sum_ns / NS)


def quantile_s(counts: Sequence[int], share: float) -> float:
    """The duration that `share` of the counted ones kept to, s; evenly spread within its bucket.

    What lies beyond the last bound is told as that bound. Raises ValueError where nothing was counted.
    """
    left = share * sum(counts)
    for bucket, count in enumerate(counts):
        if count and left <= count:
            lower = UPPERS_NS[bucket - 1] if bucket else 0
            upper = UPPERS_NS[min(bucket, _LAST - 1)]
            return (lower + (upper - lower) * left / count) / NS
        left -= count
    raise ValueError("nothing was counted")
