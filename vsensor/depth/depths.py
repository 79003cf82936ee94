"""The depths of bit and hole: what they tell of the bit and of the string's length.

The bit hangs on the string, so its depth lies between the string's length and a stand less, the part that
sticks out above the rotary table. Where it does not, stands were added or taken off: a connection.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Rig
from vsensor.depth.belief import SILENT_S, Belief, Doubt, Known, Told
from vsensor.grid import NS
from vsensor.messages import DEPTH_TOPICS, SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH, Sample
from vsensor.quality import Quality
from vsensor.saved import Saved

SLACK_M = 3.0
"""The depth counts from another point than the string's length, stretch comes on top: so much is no stand."""
MOST_STANDS = 10
"""A greater step is no connection, but a wrong unit or another string: it is left alone."""
DEEPEST_M = 20_000.0
"""Deeper than any well: no depth."""


class Depths:
    """The two depth channels of one rig."""

    def __init__(self, rig: Rig) -> None:
        self._stand = rig.depth.stand
        self._clearance = rig.depth.off_bottom
        self._length = sum(part.length for part in rig.string)
        self._shortest = self._length - rig.string[0].length
        """Of pipe a stand must be left."""
        self._beliefs: dict[str, Belief] = {}
        self._commanded: bool | None = None
        self._longer = 0.0
        self._unfit = 0
        self.at_odds = False
        """Whether the bit's depth and the string's length differ by more than a connection could."""

    @property
    def length(self) -> float:
        """Of the string, m, with what was added while running."""
        return self._length

    @property
    def refused(self) -> int:
        """Samples that are no depth, or were doubted and not borne out."""
        return self._unfit + sum(belief.refused for belief in self._beliefs.values())

    def off_bottom(self, time_ns: int) -> bool:
        """At a tick's time: as commanded; else as the depths tell; on bottom where one of them is not known.

        That is the safe side. A bit that in truth still hangs free teaches the load law that the rock gives
        way, which it unlearns within a minute; one that drills while it is held to be free would have its
        rock taken for friction of the wall, and that is kept.
        """
        if self._commanded is not None:
            return self._commanded
        return self._lifted and not self.silent(time_ns)

    def off_bottom_at(self, times_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
        """The same at n ticks, shape (n,)."""
        if self._commanded is not None or not self._lifted:
            return np.full(len(times_ns), bool(self._commanded))
        first_ns, last_ns = self._counts()
        return (times_ns >= first_ns) & (times_ns <= last_ns)

    def silent(self, time_ns: int) -> bool:
        """Whether a channel that has told a depth tells none of this time."""
        if not self._known:
            return False
        first_ns, last_ns = self._counts()
        return not first_ns <= time_ns <= last_ns

    def take(self, topic: str, sample: Sample | None) -> None:
        """Take a sample of a depth channel, m; None for one that could not be read."""
        value = math.nan if sample is None or int(sample.quality) == Quality.BAD else sample.value
        if sample is None or not 0 <= value <= DEEPEST_M:
            self.refuse()
            return
        told = Told(value, sample.time_ns)
        belief = self._beliefs[topic] = self._beliefs.get(topic, Belief()).after(told)
        believed = belief.known is not None and belief.known.told is told
        if believed and topic == SURFACE_BIT_DEPTH:
            self._count_stands(value)

    def refuse(self) -> None:
        """Count a sample that was not looked at, or is no depth."""
        self._unfit += 1

    def settles(self, topic: str, sample: Sample) -> bool:
        """Take a sample that may as well come before the ticks around it; another is not taken.

        It may where bit and string are as before, and it is no word of a lifted bit: how long that counts
        hangs on which ticks it came between.
        """
        before = self._commanded, self._lifted, self._length
        beliefs, unfit, at_odds, longer = dict(self._beliefs), self._unfit, self.at_odds, self._longer
        self.take(topic, sample)
        after = self._commanded, self._lifted, self._length
        if after == before and (self._commanded is not None or not self._lifted):
            return True
        self._beliefs, self._unfit, self.at_odds, self._longer = beliefs, unfit, at_odds, longer
        self._length = before[2]
        return False

    def command(self, off_bottom: bool | None) -> None:
        """Hold the bit to be off bottom, or on it, whatever the depths say; None: as they say."""
        self._commanded = off_bottom

    def lengthen(self, metres: float) -> None:
        """Make the string longer by so much, shorter if negative. ValueError with why that cannot be."""
        most = MOST_STANDS * self._stand
        if abs(metres) > most:
            raise ValueError(
                f"{abs(metres):.1f} m are more than {most:.1f} m, {MOST_STANDS} stands, at a time"
            )
        longer = self._length + metres
        if longer > DEEPEST_M:
            raise ValueError(
                f"the string would be {longer:.1f} m long: no well is deeper than {DEEPEST_M:g} m"
            )
        if longer < self._shortest + self._stand:
            raise ValueError(f"the string is {self._length:.1f} m long: no pipe would be left of it")
        self._longer += metres
        self._length = longer

    @property
    def length_at_tick(self) -> float:
        """Of the string at the newest tick, m: without what `longer_by` has still to tell."""
        return self._length - self._longer

    def longer_by(self) -> float:
        """By how much the string has become longer since the last call, m."""
        longer, self._longer = self._longer, 0.0
        return longer

    def save(self) -> dict[str, Any]:
        """What is remembered, as plain values."""
        return {
            "length": self._length,
            "longer": self._longer,
            "commanded": self._commanded,
            "told": {topic: [*known.told, known.lasts_ns] for topic, known in self._known.items()},
            "doubted": {
                topic: [*doubt.newest, doubt.since_ns, doubt.samples]
                for topic, belief in self._beliefs.items()
                if (doubt := belief.doubt) is not None
            },
        }

    def restore(self, saved: Saved) -> None:
        """Take up what `save` gave; depths of a version that kept no times of them are not known.

        Raises ValueError for what it cannot have given, and is then of no use any more.
        """
        longest = max(DEEPEST_M, self._length) + SLACK_M
        self._length = saved["length"].number(math.nextafter(self._shortest, math.inf), longest)
        self._longer = saved["longer"].number(-longest, longest)
        self._commanded = saved["commanded"].or_none(Saved.flag)
        known = {topic: _known(row) for topic, row in saved.get("told", {}).items(DEPTH_TOPICS)}
        doubts = {topic: _doubt(row) for topic, row in saved.get("doubted", {}).items(DEPTH_TOPICS)}
        topics = known.keys() | doubts.keys()
        self._beliefs = {topic: Belief(known.get(topic), doubts.get(topic)) for topic in topics}

    @property
    def _known(self) -> dict[str, Known]:
        return {topic: belief.known for topic, belief in self._beliefs.items() if belief.known is not None}

    @property
    def _lifted(self) -> bool:
        """Whether the bit hangs above the hole's bottom, as it was told last."""
        bit, hole = self._beliefs.get(SURFACE_BIT_DEPTH), self._beliefs.get(SURFACE_HOLE_DEPTH)
        if bit is None or hole is None or bit.known is None or hole.known is None:
            return False
        return hole.known.told.value - bit.known.told.value > self._clearance

    def _counts(self) -> tuple[int, int]:
        """From when to when what is known counts; of both channels, where both have spoken."""
        known = self._known.values()
        first_ns = max(told.time_ns for told, _ in known) - round(SILENT_S * NS)
        return first_ns, min(told.time_ns + lasts_ns for told, lasts_ns in known)

    def _count_stands(self, bit_depth: float) -> None:
        above = self._length - bit_depth
        if above < -SLACK_M:
            stands = math.ceil((-SLACK_M - above) / self._stand)
        elif above > self._stand + SLACK_M:
            stands = -math.floor((above - SLACK_M) / self._stand)
        else:
            self.at_odds = False
            return
        try:
            self.lengthen(stands * self._stand)
        except ValueError:
            self.at_odds = True
        else:
            self.at_odds = False


def _told(value: Saved, time_ns: Saved) -> Told:
    return Told(value.number(0, DEEPEST_M), time_ns.whole(-1 << 63, (1 << 63) - 1))


def _known(saved: Saved) -> Known:
    value, time_ns, lasts_ns = saved.row(3)
    return Known(_told(value, time_ns), lasts_ns.whole(0, round(SILENT_S * NS)))


def _doubt(saved: Saved) -> Doubt:
    value, time_ns, since_ns, samples = saved.row(4)
    newest = _told(value, time_ns)
    return Doubt(newest, since_ns.whole(-1 << 63, newest.time_ns), samples.whole(1, 1 << 53))
