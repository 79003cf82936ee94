"""The tick's grid: absolute and in whole nanoseconds, so that no error adds up however long it runs."""

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

NS = 1_000_000_000

_SPLIT = 2.0**27 + 1
"""Parts a double in two halves, whose products with NS are exact (Veltkamp)."""


class Grid:
    """Ticks at a rate (Hz), each at the last whole nanosecond before its own place."""

    def __init__(self, rate: float) -> None:
        period = Fraction(NS) / Fraction(rate).limit_denominator(10**6)
        self._ns, self._per = period.numerator, period.denominator

    def after_ns(self, number: int) -> int:
        """How long after the first tick the one of a number comes, ns."""
        return number * self._ns // self._per

    def until_ns(self, first: int, last_ns: int) -> NDArray[np.int64]:
        """The same of all ticks from number `first` on that come no later than `last_ns`."""
        begin_ns = self.after_ns(first)
        if begin_ns > last_ns:
            return np.empty(0, np.int64)
        # As begin + k · period, the period in whole nanoseconds and the rest: 64 bits hold all of it.
        whole, rest = divmod(self._ns, self._per)
        left = first * self._ns % self._per
        k = np.arange((last_ns - begin_ns) // max(whole, 1) + 2)
        times = begin_ns + k * whole + (left + k * rest) // self._per
        return times[times <= last_ns]


def seconds(times_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Times in seconds, the doubles nearest to them; n of them.

    As doubles before they are divided, the nanoseconds would be rounded twice. So whole seconds and
    the rest are divided apart, what the rest's division leaves is kept (Dekker 1971), the sum is rounded.
    """
    whole, rest = np.divmod(times_ns, NS)
    share = rest / NS
    high = share * _SPLIT - (share * _SPLIT - share)
    left = ((rest - high * NS) - (share - high) * NS) / NS
    near = whole + share
    return near + ((whole - near) + share + left)
