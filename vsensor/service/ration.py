"""How much of a turn may go into samples: what ends within most of a slot, more only where a backlog lasts.

What comes in a bunch is worked off over the turns that follow, each on time. Where that does not do it,
turns reach into the next slot: then the processor never rests, each slot begins late, and still has its turn.
After a cut there is more than that, and it is better to skip slots for a while than to be behind for long.
"""

import time

from vsensor.grid import NS

SHARE = 0.7
"""Of a slot: a sample that will not be half done with by then, if it takes as long as the longest of this
turn, waits for the next. Half, as the first tick of a turn, for which nothing is in the processor's caches,
takes twice as long as those behind it: a backlog of which one is done each turn would stand for ever."""
SOON_S = 0.025
MOST_SHARE = 1.3
"""Where a backlog is still there after so long, so much of a slot. A slot is skipped where the turn before it
lasts for two: that leaves time for what else a turn has to do;"""
PATIENCE_S = 2.0
"""and after so long it lasts:"""
GROWTH = 1.1
GROWTH_HZ = 1000.0
"""then a turn has so many times the time that the one before had, this often a second at the most: at 1 kHz,
to the longest in some 40 turns."""
LONGEST_S = 0.05
"""Status, commands and signals do not wait longer."""


class Ration:
    """The time that turns have for samples."""

    def __init__(self, rate_hz: float) -> None:
        self._least_ns = round(SHARE * NS / rate_hz)
        self._soon_ns = round(MOST_SHARE * NS / rate_hz)
        self._most_ns = max(self._soon_ns, round(LONGEST_S * NS))
        self._growth = GROWTH ** min(1.0, GROWTH_HZ / rate_hz)
        self._soon, self._patience = int(SOON_S * rate_hz), int(PATIENCE_S * rate_hz)
        self._ns = self._least_ns
        self._until_ns = self._longest_ns = 0
        self._asked_ns: int | None = None
        self._spent = False
        self._in_a_row = 0

    def begin(self, lateness_ns: int = 0) -> None:
        """A turn begins, so late: longer than the one before if those before had too little time for long.

        What it is late by is lost to it, unless there is a backlog: else the next would be late as well.
        """
        self._in_a_row = self._in_a_row + 1 if self._spent else 0
        grows = self._in_a_row > self._patience
        if grows:
            self._ns = min(round(self._growth * self._ns), self._most_ns)
        else:
            self._ns = self._soon_ns if self._in_a_row > self._soon else self._least_ns
        self._spent = False
        self._asked_ns, self._longest_ns = None, 0
        self._until_ns = time.monotonic_ns() + self._ns - (0 if grows else lateness_ns)

    def lasts(self) -> bool:
        """Whether there is time for another sample: for the first of a turn there always is."""
        now = time.monotonic_ns()
        if self._asked_ns is not None:
            self._longest_ns = max(self._longest_ns, now - self._asked_ns)
            self._spent = now + self._longest_ns // 2 > self._until_ns
        self._asked_ns = now
        return not self._spent
