"""What the depths tell: whether the bit is off bottom, and by how many stands the string is longer.

The bit hangs on the string, so its depth lies between the string's length and a stand less, the part that
sticks out above the rotary table. Where it does not, stands were added or taken off: a connection.
"""

import math
from collections.abc import Mapping
from typing import Any

from vsensor.config import Rig
from vsensor.messages import SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH, Sample
from vsensor.quality import Quality

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
        self._known: dict[str, float] = {}
        self._commanded: bool | None = None
        self._longer = 0.0
        self.refused = 0
        """Depths beyond belief."""
        self.at_odds = False
        """Whether the bit's depth and the string's length differ by more than a connection could."""

    @property
    def length(self) -> float:
        """Of the string, m, with what was added while running."""
        return self._length

    @property
    def off_bottom(self) -> bool:
        """As commanded; else as the depths tell; on bottom where neither says anything."""
        if self._commanded is not None:
            return self._commanded
        bit, hole = (self._known.get(topic) for topic in (SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH))
        return bit is not None and hole is not None and hole - bit > self._clearance

    def take(self, topic: str, sample: Sample | None) -> None:
        """Take a sample of a depth channel, m; None for one that could not be read."""
        value = math.nan if sample is None or int(sample.quality) == Quality.BAD else sample.value
        if not 0 <= value <= DEEPEST_M:
            self.refused += 1
            return
        self._known[topic] = value
        if topic == SURFACE_BIT_DEPTH:
            self._count_stands(value)

    def settles(self, topic: str, sample: Sample) -> bool:
        """Take a sample after which bit and string are as before; one that would change them is not taken."""
        before = self.off_bottom, self._length
        known, refused, at_odds, longer = dict(self._known), self.refused, self.at_odds, self._longer
        self.take(topic, sample)
        if (self.off_bottom, self._length) == before:
            return True
        self._known, self.refused, self.at_odds, self._longer = known, refused, at_odds, longer
        self._length = before[1]
        return False

    def command(self, off_bottom: bool | None) -> None:
        """Hold the bit to be off bottom, or on it, whatever the depths say; None: as they say."""
        self._commanded = off_bottom

    def lengthen(self, metres: float) -> bool:
        """Make the string longer by so much, shorter if negative; whether pipe enough is left."""
        if self._length + metres < self._shortest + self._stand:
            return False
        self._longer += metres
        self._length += metres
        return True

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
            "known": self._known,
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Take up what `save` gave."""
        self._length = saved["length"]
        self._longer = saved["longer"]
        self._commanded = saved["commanded"]
        self._known = dict(saved["known"])

    def _count_stands(self, bit_depth: float) -> None:
        above = self._length - bit_depth
        if above < -SLACK_M:
            stands = math.ceil((-SLACK_M - above) / self._stand)
        elif above > self._stand + SLACK_M:
            stands = -math.floor((above - SLACK_M) / self._stand)
        else:
            self.at_odds = False
            return
        self.at_odds = abs(stands) > MOST_STANDS or not self.lengthen(stands * self._stand)
