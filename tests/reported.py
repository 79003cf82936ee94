"""Ticks for the report's tests: a bit that does what it is told, in pieces as a session gives them."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np

from vsensor.report.ticks import Ticks

NS = 1_000_000_000


def ticks(bit: np.ndarray, top: float = 10.0, rate: int = 50, begin_ns: int = 0) -> Ticks:
    """Ticks in which the bit does this, confirmed a second late; now is half a rad/s above it."""
    count = len(bit)
    time_ns = begin_ns + np.arange(count) * (NS // rate)
    names = ("confirmed_bit_torque_nm", "top_torque_nm", "now_bit_torque_nm", "forecast_bit_torque_nm")
    columns = {
        **{name: np.full(count, 1000.0) for name in names},
        "confirmed_bit_speed_rad_s": bit,
        "top_speed_rad_s": np.full(count, top),
        "now_bit_speed_rad_s": np.roll(bit, -rate) + 0.5,
        "forecast_bit_speed_rad_s": np.roll(bit, -2 * rate) - 2.0,
        "quality": np.ones(count),
    }
    return Ticks(time_ns, time_ns - NS, time_ns + NS, columns)


def pieces(told: Ticks, cuts: Iterable[int]) -> Iterator[Ticks]:
    """The same ticks, cut before each of these."""
    number = np.arange(len(told))
    bounds = [0, *sorted(min(cut, len(told)) for cut in cuts), len(told)]
    for begin, end in pairwise(bounds):
        if end > begin:
            yield told.of((number >= begin) & (number < end))
