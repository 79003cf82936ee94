"""What each second of a session comes to: of that, how rough it was, and when it was worst."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from vsensor.grid import NS
from vsensor.report.grown import Grown
from vsensor.report.ticks import BIT, TOP, Floats, Ticks, Times

MOVING = 0.1
"""A mean speed below this (rad/s, 1 rpm) is no rotation."""
WORST_S = 60
"""So many seconds of a session are shown closely."""

_SUMS = ("number", "total", "apart")

_Rows = dict[str, npt.NDArray[Any]]


class Severity(NamedTuple):
    """(max − min) / (2 · mean) of the bit's confirmed speed over the seconds before each second."""

    time_ns: Times
    value: Floats
    window_s: float


class Seconds:
    """The bit's confirmed speed in each second: least, greatest, number and total of what is known of it.

    And how far it was from the top's, squared. A second takes 48 bytes, a day 4 MB; one without ticks
    takes none, so that a clock that leaps costs nothing.
    """

    def __init__(self) -> None:
        self._first_ns: int | None = None
        self._columns = {name: Grown(np.float64) for name in ("least", "greatest", *_SUMS)}
        self._columns["second"] = Grown(np.int64)

    def add(self, ticks: Ticks) -> None:
        """Add ticks, whatever their order."""
        if not len(ticks):
            return
        if self._first_ns is None:
            self._first_ns = int(ticks.confirmed_ns[0])
        known = np.isfinite(ticks[BIT])
        bit, apart = np.where(known, ticks[BIT], np.nan), ticks[BIT] - ticks[TOP]
        rows: _Rows = {
            "second": (ticks.confirmed_ns - self._first_ns) // NS,
            "least": bit,
            "greatest": bit,
            "number": known.astype(np.float64),
            "total": np.where(known, bit, 0.0),
            "apart": np.where(np.isfinite(apart), apart, 0.0) ** 2,
        }
        for name, values in _by_second(rows).items():
            self._columns[name].add(values)

    def severity(self, window_s: float) -> Severity:
        """Severity over a window, told each second; NaN where half of it is not known, or nothing turns."""
        width = max(1, round(window_s))
        time_ns, rows = self._side_by_side(width)
        width = min(width, len(time_ns))

        def over(name: str) -> Floats:
            return np.asarray(np.lib.stride_tricks.sliding_window_view(rows[name], width))

        number = over("number")
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = over("total").sum(axis=1) / number.sum(axis=1)
            swing = np.fmax.reduce(over("greatest"), axis=1) - np.fmin.reduce(over("least"), axis=1)
            full = 2 * np.count_nonzero(number, axis=1) >= width
            value = np.where(full & (np.abs(mean) >= MOVING), swing / (2 * np.abs(mean)), np.nan)
        return Severity(time_ns[width - 1 :] + NS, value, float(width))

    def worst(self) -> tuple[int, int]:
        """Begin and end (ns) of the minute in which the bit's speed was furthest (rms) from the top's."""
        time_ns, rows = self._side_by_side(WORST_S)
        width = min(WORST_S, len(time_ns))
        apart = np.convolve(rows["apart"], np.ones(width), "valid")
        end = int(time_ns[width - 1 :][np.argmax(apart)]) + NS
        return end - width * NS, end

    def _side_by_side(self, longest_gap: int) -> tuple[Times, _Rows]:
        """When each second begins, and its row: those without ticks too, of a long gap so many of them."""
        rows = _by_second({name: column.whole() for name, column in self._columns.items()})
        second = rows.pop("second")
        steps = np.minimum(np.diff(second), longest_gap + 1)
        place = np.concatenate(([0], np.cumsum(steps)))
        every = np.arange(place[-1] + 1)
        before = np.searchsorted(place, every, side="right") - 1
        times = (self._first_ns or 0) + (second[before] + every - place[before]) * NS
        filled = {name: np.full(len(every), 0.0 if name in _SUMS else np.nan) for name in rows}
        for name, values in rows.items():
            filled[name][place] = values
        return times, filled


def _by_second(rows: _Rows) -> _Rows:
    """Rows put together, one for each second, in the order of time."""
    order = np.argsort(rows["second"], kind="stable")
    second = rows["second"][order]
    starts = np.flatnonzero(np.diff(second, prepend=second[0] - 1))
    together: _Rows = {
        "second": second[starts],
        "least": np.fmin.reduceat(rows["least"][order], starts),
        "greatest": np.fmax.reduceat(rows["greatest"][order], starts),
    }
    return together | {name: np.add.reduceat(rows[name][order], starts) for name in _SUMS}
