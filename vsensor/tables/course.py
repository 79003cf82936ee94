"""How a table's times go on from row to row: over midnight, and through the hour that autumn repeats."""

import numpy as np
import numpy.typing as npt

from vsensor.grid import NS

Times = npt.NDArray[np.int64]

_DAY_NS = 86_400 * NS


class Course:
    """What the rows so far tell of those to come."""

    def __init__(self) -> None:
        self._last_ns: int | None = None
        self._days = 0
        self._folded, self._second = False, False
        """Whether the last row was in an hour that comes twice, and in which of the two."""

    def on_days(self, of_day: Times) -> Times:
        """Times of day alone, ns: where they jump back by more than 12 h the next day begins."""
        days = self._days + np.cumsum(self._steps(of_day) < -_DAY_NS // 2)
        self._days = int(days[-1])
        return of_day + days * _DAY_NS

    def told_apart(self, wall: Times, early: Times, late: Times) -> Times:
        """Of the two times that a clock on the wall may mean, ns: the later one once it has jumped back.

        Where it means one alone, both are the same.
        """
        folded = early != late
        back = folded & (2 * self._steps(wall) < early - late)
        jumps = np.cumsum(back) + self._second
        enters = folded & ~np.append(self._folded, folded[:-1])
        second = folded & (jumps > np.maximum.accumulate(np.where(enters, jumps, 0)))
        self._folded, self._second = bool(folded[-1]), bool(second[-1])
        return np.where(second, late, early)

    def _steps(self, times: Times) -> Times:
        """How far each is from the one before."""
        steps = np.diff(times, prepend=times[0] if self._last_ns is None else self._last_ns)
        self._last_ns = int(times[-1])
        return steps
