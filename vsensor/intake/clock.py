"""Whether a channel's clock was set, by so little that nothing begins anew of itself.

By its numbers no sample is missing, and yet there is a hole in time, or what comes lies behind what was told.
One channel alone may have paused, or come in the wrong order; where both do so together the source's clock
was set.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.saved import Saved

LATELY = 32
"""So many times from one sample to the next tell what is usual,"""
KNOWN = 8
"""and so few already."""
HOLE = 5
"""A hole is longer than so many times the longest of them,"""
SHORTEST_NS = 30_000_000
"""and than this: what is measured often may well pause for a moment."""
FEWEST, LASTING_NS = 5, 20_000_000
"""So many samples in a row, over so long a time, lie behind what was told where the clock was set back."""
_FARTHEST = 1 << 63


class Behind(NamedTuple):
    """Samples in a row, each later than the one before, behind the newest that was told before them."""

    samples: int
    begun_ns: int
    newest_ns: int


NONE = Behind(0, 0, 0)


class Clock:
    """One channel's times, in the order of its numbers."""

    def __init__(self) -> None:
        self.told_ns: int | None = None
        """The time of the last sample that had a number."""
        self.apart: list[int] = []
        """Times between the last ones in turn, oldest first."""
        self.hole = (0, 0)
        """The newest hole in time that is none in the numbers: from, to."""
        self.forget()

    def forget(self) -> None:
        """Take it that nothing lies behind; what is usual stays."""
        self.behind = NONE

    @property
    def fell_back(self) -> bool:
        """Whether all that comes lies behind what was told."""
        behind = self.behind
        return behind.samples >= FEWEST and behind.newest_ns - behind.begun_ns >= LASTING_NS

    def falls_behind(self, time_ns: int) -> None:
        """Take account of a sample that lies behind what was told, and is no old one sent again."""
        if self.behind.samples and time_ns > self.behind.newest_ns:
            self.behind = Behind(self.behind.samples + 1, self.behind.begun_ns, time_ns)
        else:
            self.behind = Behind(1, time_ns, time_ns)

    def follow(self, time_ns: int, in_turn: bool) -> None:
        """Take account of the next sample with a number, whatever became of it."""
        told_ns, self.told_ns = self.told_ns, time_ns
        if told_ns is None or not in_turn or time_ns <= told_ns:
            return
        apart = time_ns - told_ns
        if apart > SHORTEST_NS and len(self.apart) >= KNOWN and apart > HOLE * max(self.apart):
            self.hole = (told_ns, time_ns)
        self.apart.append(apart)
        if len(self.apart) > LATELY:
            del self.apart[0]

    def hole_with(self, other: "Clock") -> tuple[int, int]:
        """The newest hole as far as the other has it too: from, to."""
        return max(self.hole[0], other.hole[0]), min(self.hole[1], other.hole[1])

    def look(self, times_ns: NDArray[np.int64], in_turn: bool) -> list[int] | None:
        """What `apart` is after n samples in turn, later and later; None where there may be a hole.

        `in_turn`: the first of them is the one that was due.
        """
        apart = np.diff(times_ns)
        if in_turn and self.told_ns is not None:
            first = int(times_ns[0]) - self.told_ns
            if not 0 < first < _FARTHEST:
                return None
            apart = np.append(first, apart)
        told = np.append(np.array(self.apart, np.int64), apart)
        holes = (told[1:] > SHORTEST_NS) & (told[1:] // HOLE >= told[:-1])
        if np.any(holes[max(len(self.apart) - 1, 0) :]):
            return None
        return [int(each) for each in told[-LATELY:]]

    def save(self) -> list[Any]:
        """What is remembered, as plain values."""
        return [self.told_ns, list(self.apart), list(self.hole), list(self.behind)]

    def restore(self, saved: Saved) -> None:
        """Take up what `save` gave. Raises ValueError for what it cannot have given."""
        told_ns, apart, hole, behind = saved.row(4)
        self.told_ns = told_ns.or_none(_a_time)
        self.apart = [each.whole(1, _FARTHEST - 1) for each in apart.rows()]
        if len(self.apart) > LATELY:
            raise apart.wrong(f"a list of {LATELY} at the most")
        begun, ended = hole.row(2)
        self.hole = (_a_time(begun), _a_time(ended))
        count, first, newest = behind.row(3)
        self.behind = Behind(count.whole(0, 1 << 53), _a_time(first), _a_time(newest))


def _a_time(saved: Saved) -> int:
    return saved.whole(-_FARTHEST, _FARTHEST - 1)
