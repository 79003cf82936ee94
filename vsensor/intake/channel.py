"""One surface channel: what is refused and why, and the samples that the grid still needs."""

import math
from bisect import bisect
from itertools import pairwise
from typing import Any, NamedTuple

from vsensor.intake.clock import Clock
from vsensor.intake.leaps import Leaps
from vsensor.intake.reach import Reach
from vsensor.intake.repeats import Heard, Repeats
from vsensor.intake.sequence import Sequence
from vsensor.messages import ChannelStatus, Sample
from vsensor.messages.books import REFUSALS
from vsensor.quality import Quality, Reason
from vsensor.saved import Saved

FARTHEST_NS = 1 << 62
"""A time beyond 146 years from 1970 is none: near the end of its 64 bits, a forecast's would not fit."""
_BAD, _UNCERTAIN, _SOURCE_UNCERTAIN = int(Quality.BAD), int(Quality.UNCERTAIN), int(Reason.SOURCE_UNCERTAIN)
_GAP_BRIDGED = int(Reason.GAP_BRIDGED)
"""As plain numbers: sets of flags would take more time here than all else that is done to a sample."""


def a_time(saved: Saved) -> int:
    """A recorded time of a surface sample or a tick. Raises ValueError for what cannot be one."""
    return saved.whole(-FARTHEST_NS, FARTHEST_NS)


class Point(NamedTuple):
    """An accepted sample."""

    time_ns: int
    value: float
    reasons: int
    """Flags of `Reason`."""


class Channel:
    """One channel: what is refused and why, and the points that the grid still needs."""

    def __init__(
        self, name: str, limit: float, noise: float, stale: Reason, reach: Reach, max_gap_ns: int
    ) -> None:
        self.counts = ChannelStatus(
            channel=name, received=0, accepted=0, lost=0, **dict.fromkeys(REFUSALS, 0)
        )
        self._stale = int(stale)
        self.limit = limit
        self.leaps = Leaps(noise, limit)
        self.reach = reach
        self.repeats = Repeats(max_gap_ns)
        self.sequence = Sequence()
        self.clock = Clock()
        self.pace_ns: int | None = None
        """How far apart its two newest samples are."""
        self.waiting: Point | None = None
        """A sample far ahead of the others, or whose value leaps, which the next one must bear out."""
        self.forget()

    def forget(self) -> None:
        """Begin anew, as before the first sample; counts, pace and what is usual stay."""
        if self.waiting is not None:
            if self._leaps(self.waiting):
                self.counts.strays += 1
            else:
                self.counts.jumped += 1
        self.waiting = None
        self.reach.apart = None
        self.repeats.forget()
        self.clock.forget()
        self.points: list[Point] = []

    @property
    def newest_ns(self) -> int | None:
        """The time of the newest accepted sample."""
        return self.points[-1].time_ns if self.points else None

    def believes(self, sample: Sample) -> bool:
        """Whether value and quality of a sample can be used; counts it otherwise."""
        if not math.isfinite(sample.value):
            self.counts.not_finite += 1
        elif abs(sample.value) > self.limit:
            self.counts.out_of_range += 1
        elif sample.quality == _BAD:
            self.counts.bad_at_source += 1
        else:
            return True
        return False

    def is_new(self, sample: Sample) -> bool:
        """Whether a sample is a new reading; counts it otherwise: what repeats the last one is in order."""
        if not self.repeats.is_one(sample.time_ns, sample.value):
            return True
        self.counts.accepted += 1
        return False

    def follow(self, sample: Sample) -> None:
        """Follow the sequence: a hole is a loss, until the missing one comes late after all."""
        if sample.HasField("sequence"):
            self.clock.follow(sample.time_ns, sample.sequence == self.sequence.due)
            more = self.sequence.follow(sample.sequence, sample.time_ns == self._told_last_ns())
            # What was missed before a state was taken up is in no count.
            self.counts.lost = max(self.counts.lost + more, 0)
        else:
            self.clock.told_ns = None

    def falls_back(self, sample: Sample) -> bool:
        """Whether a sample, and those before it, lie behind what was told, and are no old ones sent again."""
        newest_ns, due = self.newest_ns, self.sequence.due
        if newest_ns is None or sample.time_ns > newest_ns:
            self.clock.forget()
        elif due is None or not sample.HasField("sequence") or sample.sequence >= due:
            self.clock.falls_behind(sample.time_ns)
        return self.clock.fell_back

    def refuse_unread(self) -> None:
        """Count a sample that came too fast; the hole that it leaves in the sequence is no loss."""
        self.counts.received += 1
        self.counts.over_rate += 1
        self.sequence.pass_unread()

    def _told_last_ns(self) -> int | None:
        return self.newest_ns if self.waiting is None else self.waiting.time_ns

    def take(self, sample: Sample, consumed_ns: int | None, max_gap_ns: int) -> None:
        """Keep a sample in its place in time, unless that has passed or is taken.

        One that comes more than a gap before it is due waits for the next, which bears it out by being later
        still, and not by lying before it: else a single stray would stand for all up to its time. One whose
        value leaps waits for the next as well: see `settle`; one that it cannot have become is refused.
        """
        if self._is_out_of_reach(sample.time_ns, sample.value):
            self.counts.strays += 1
            return
        reasons = _SOURCE_UNCERTAIN if sample.quality == _UNCERTAIN else 0
        if self.sequence.contested:  # whose it is nobody knows
            reasons |= self._stale
        point = Point(sample.time_ns, sample.value, reasons)
        waiting = self.waiting
        if waiting is None or point.time_ns <= self.points[-1].time_ns:
            self._take_up(point, consumed_ns, max_gap_ns)
        elif point.time_ns == waiting.time_ns:
            self.counts.doubled += 1
        elif point.time_ns > waiting.time_ns:
            self.settle(point.value, consumed_ns)
            self._take_up(point, consumed_ns, max_gap_ns)
        elif self._is_ahead(waiting, max_gap_ns):
            self.waiting = None
            self.counts.jumped += 1
            self._take_up(point, consumed_ns, max_gap_ns)
        else:  # the two came in the wrong order
            self.waiting = None
            self._take_up(point, consumed_ns, max_gap_ns)
            self.settle(waiting.value, consumed_ns)
            self._take_up(waiting, consumed_ns, max_gap_ns)

    def _is_out_of_reach(self, time_ns: int, value: float) -> bool:
        newest = self.points[-1] if self.points else None
        if newest is None or time_ns <= newest.time_ns:
            return False
        return self.reach.refuses(newest.time_ns, newest.value, time_ns, value)

    def settle(self, value: float, consumed_ns: int | None) -> None:
        """Accept the sample that waits, unless its value leaps and `value`, the next one's, is no nearer."""
        if self.waiting is not None:
            point, self.waiting = self.waiting, None
            if self._is_stray(point, self.points[-1], value):
                self.counts.strays += 1
            else:
                self._accept(point, consumed_ns)

    def patience_ns(self, max_gap_ns: int) -> int:
        """For how much longer than a gap the other channel may wait for the next sample of this one."""
        if self.waiting is None or self.pace_ns is None or self._is_ahead(self.waiting, max_gap_ns):
            return 0
        return self.pace_ns

    def _take_up(self, point: Point, consumed_ns: int | None, max_gap_ns: int) -> None:
        """Accept a sample that no other must wait for, or let it wait."""
        newest = self.points[-1] if self.points else None
        if newest is not None and point.time_ns > newest.time_ns:
            change = abs(point.value - newest.value)
            leaps = self.leaps.is_one(change)
            self.leaps.note(change)
            if leaps or self._is_ahead(point, max_gap_ns):
                self.waiting = point
                return
        self._accept(point, consumed_ns)

    def _is_ahead(self, point: Point, max_gap_ns: int) -> bool:
        """Whether one behind the newest comes more than a gap before it is due."""
        return (
            self.pace_ns is not None and point.time_ns - self.points[-1].time_ns > self.pace_ns + max_gap_ns
        )

    def _leaps(self, point: Point) -> bool:
        return self.leaps.is_one(abs(point.value - self.points[-1].value))

    def _is_stray(self, point: Point, before: Point, behind: float) -> bool:
        """Whether a value leaps, and the one behind it lies nearer to the one before."""
        leaps = self.leaps.is_one(abs(point.value - before.value))
        return leaps and abs(behind - point.value) >= abs(behind - before.value)

    def _accept(self, point: Point, consumed_ns: int | None) -> None:
        newest = self.newest_ns
        if newest is None or point.time_ns > newest:
            if newest is not None:
                self.pace_ns = point.time_ns - newest
            self.points.append(point)
        elif any(kept.time_ns == point.time_ns for kept in self.points):
            self.counts.doubled += 1
            return
        elif consumed_ns is not None and point.time_ns <= consumed_ns:
            self.counts.late += 1
            return
        else:
            at = bisect(self.points, point)
            if at and self._is_stray(point, self.points[at - 1], self.points[at].value):
                self.counts.strays += 1
                return
            self.points.insert(at, point)
        self.counts.accepted += 1

    def save(self) -> dict[str, Any]:
        """What the channel remembers, but for its counts, as plain values."""
        return {
            "points": [list(point) for point in self.points],
            "pace_ns": self.pace_ns,
            "waiting": None if self.waiting is None else list(self.waiting),
            **self.sequence.save(),
            "repeats": self.repeats.save(),
            "leaps": self.leaps.save(),
            "apart": self.reach.save(),
            "clock": self.clock.save(),
        }

    def restore(self, saved: Saved) -> None:
        """Take up what `save` gave, or an older version, which waited for none; the counts stay.

        Raises ValueError for what it cannot have given.
        """
        self.points = [self._point(row) for row in saved["points"].rows()]
        if any(later.time_ns <= point.time_ns for point, later in pairwise(self.points)):
            raise saved["points"].wrong("a list in the order of time")
        self.pace_ns = saved.get("pace_ns", None).or_none(lambda pace: pace.whole(1, 2 * FARTHEST_NS))
        self.waiting = saved.get("waiting", None).or_none(self._point)
        self.sequence.restore(saved)
        self.repeats.heard = Heard()
        saved.get("repeats", None).or_none(lambda heard: self.repeats.restore(heard, self.limit, FARTHEST_NS))
        self.leaps.forget()
        saved.get("leaps", None).or_none(self.leaps.restore)
        self.reach.apart = None
        saved.get("apart", None).or_none(lambda apart: self.reach.restore(apart, FARTHEST_NS))
        self.clock = Clock()
        saved.get("clock", None).or_none(self.clock.restore)

    def _point(self, saved: Saved) -> Point:
        time_ns, value, flags = saved.row(3)
        return Point(
            a_time(time_ns),
            value.number(-self.limit, self.limit),
            flags.whole(0, int(~Reason(0))),
        )

    def let_go(self, time_ns: int) -> None:
        """Drop what lies before a time, but for the last of it."""
        while len(self.points) > 1 and self.points[1].time_ns <= time_ns:
            del self.points[0]

    def at(self, time_ns: int, max_gap_ns: int) -> tuple[float, int] | None:
        """The value at a time by a straight line between its neighbours; None where not reached yet."""
        self.let_go(time_ns)
        before = self.points[0]
        if before.time_ns == time_ns:
            return before.value, before.reasons
        if len(self.points) == 1:
            return None
        after = self.points[1]
        reasons = before.reasons | after.reasons
        gap = after.time_ns - before.time_ns
        if gap > max_gap_ns:
            reasons |= _GAP_BRIDGED
        share = (time_ns - before.time_ns) / gap
        return before.value + share * (after.value - before.value), reasons

    def has_gone_on(self, time_ns: int, max_gap_ns: int) -> bool:
        """Whether samples reach further than a gap past the first at or after a time.

        Past the time itself would not do: where both channels were silent, or are slow, one of
        them is the first to speak again, and the other a moment behind it.
        """
        following = next((point for point in self.points if point.time_ns >= time_ns), None)
        return following is not None and self.points[-1].time_ns > following.time_ns + max_gap_ns

    def held(self) -> tuple[float, int]:
        """The last value, for a channel that has fallen silent."""
        return self.points[0].value, self.points[0].reasons | self._stale
