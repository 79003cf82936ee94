"""What the depths tell: whether the bit is off bottom, and by how many stands the string is longer.

The bit hangs on the string, so its depth lies between the string's length and a stand less, the part that
sticks out above the rotary table. Where it does not, stands were added or taken off: a connection.

A depth counts for as long as its channel speaks. One that leaps farther than a bit can have moved is doubted
until it was told for some seconds: a single wrong one neither cuts the string anew nor lifts the bit.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Rig
from vsensor.grid import NS
from vsensor.messages import SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH, Sample
from vsensor.quality import Quality

SLACK_M = 3.0
"""The depth counts from another point than the string's length, stretch comes on top: so much is no stand."""
MOST_STANDS = 10
"""A greater step is no connection, but a wrong unit or another string: it is left alone."""
DEEPEST_M = 20_000.0
"""Deeper than any well: no depth."""
FRESH_S = 5.0
PERIODS = 3
"""A depth counts for so long, or for so many of its channel's periods where those are longer, and"""
SILENT_S = 30.0
"""never for longer: then the channel is silent. One so far ahead of the tick is by another clock."""
STEP_M = 5.0
FASTEST_M_S = 2.0
"""No bit moves farther than this step and so much in each second: a greater leap is doubted."""
LASTING_S = 3.0
"""A leap is believed once it was told for so long, by two samples at least."""


class Told(NamedTuple):
    """A depth, m, and when it was measured."""

    value: float
    time_ns: int

    def leads_to(self, later: "Told") -> bool:
        """Whether a bit that was here can have got there."""
        seconds = (later.time_ns - self.time_ns) / NS
        near = abs(later.value - self.value) <= STEP_M + FASTEST_M_S * seconds
        return near and 0 <= seconds <= SILENT_S


class Known(NamedTuple):
    """A depth that is believed, and how long it counts."""

    told: Told
    lasts_ns: int


class Doubt(NamedTuple):
    """Depths that agree with one another, and not with what is known."""

    newest: Told
    since_ns: int
    samples: int


class Depths:
    """The two depth channels of one rig."""

    def __init__(self, rig: Rig) -> None:
        self._stand = rig.depth.stand
        self._clearance = rig.depth.off_bottom
        self._length = sum(part.length for part in rig.string)
        self._shortest = self._length - rig.string[0].length
        """Of pipe a stand must be left."""
        self._known: dict[str, Known] = {}
        self._doubted: dict[str, Doubt] = {}
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
            self.refused += 1
        elif self._believes(topic, Told(value, sample.time_ns)) and topic == SURFACE_BIT_DEPTH:
            self._count_stands(value)

    def settles(self, topic: str, sample: Sample) -> bool:
        """Take a sample that may as well come before the ticks around it; another is not taken.

        It may where bit and string are as before, and it is no word of a lifted bit: how long that counts
        hangs on which ticks it came between.
        """
        before = self._commanded, self._lifted, self._length
        known, doubted = dict(self._known), dict(self._doubted)
        refused, at_odds, longer = self.refused, self.at_odds, self._longer
        self.take(topic, sample)
        after = self._commanded, self._lifted, self._length
        if after == before and (self._commanded is not None or not self._lifted):
            return True
        self._known, self._doubted = known, doubted
        self.refused, self.at_odds, self._longer = refused, at_odds, longer
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
            "told": {topic: [*told, lasts] for topic, (told, lasts) in self._known.items()},
            "doubted": {topic: [*newest, *rest] for topic, (newest, *rest) in self._doubted.items()},
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Take up what `save` gave; depths of a version that kept no times of them are not known."""
        self._length = saved["length"]
        self._longer = saved["longer"]
        self._commanded = saved["commanded"]
        self._known = {
            topic: Known(Told(value, time_ns), lasts_ns)
            for topic, (value, time_ns, lasts_ns) in saved.get("told", {}).items()
        }
        self._doubted = {
            topic: Doubt(Told(value, time_ns), *rest)
            for topic, (value, time_ns, *rest) in saved.get("doubted", {}).items()
        }

    @property
    def _lifted(self) -> bool:
        """Whether the bit hangs above the hole's bottom, as it was told last."""
        bit, hole = (self._known.get(topic) for topic in (SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH))
        return bit is not None and hole is not None and hole.told.value - bit.told.value > self._clearance

    def _counts(self) -> tuple[int, int]:
        """From when to when what is known counts; of both channels, where both have spoken."""
        first_ns = max(told.time_ns for told, _ in self._known.values()) - round(SILENT_S * NS)
        return first_ns, min(told.time_ns + lasts_ns for told, lasts_ns in self._known.values())

    def _believes(self, topic: str, told: Told) -> bool:
        """Whether a depth is known from now on: it follows from the one before, or has been told for long."""
        before = known.told if (known := self._known.get(topic)) is not None else None
        if before is not None and abs(told.time_ns - before.time_ns) > SILENT_S * NS:
            del self._known[topic]
            before = None
        if before is not None and told.time_ns < before.time_ns:
            return False
        doubt = self._doubted.pop(topic, None)
        if before is not None and before.leads_to(told):
            self._drop(doubt)
        elif doubt is None or not doubt.newest.leads_to(told):
            self._drop(doubt)
            self._doubted[topic] = Doubt(told, told.time_ns, 1)
            return False
        elif told.time_ns - doubt.since_ns < LASTING_S * NS:
            self._doubted[topic] = Doubt(told, doubt.since_ns, doubt.samples + 1)
            return False
        else:
            before = doubt.newest
        period_ns = told.time_ns - before.time_ns
        lasts_ns = min(max(round(FRESH_S * NS), PERIODS * period_ns), round(SILENT_S * NS))
        self._known[topic] = Known(told, lasts_ns)
        return True

    def _drop(self, doubt: Doubt | None) -> None:
        self.refused += doubt.samples if doubt is not None else 0

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
