"""How much of a turn may go into samples: half a slot, and more only where a backlog lasts.

What comes in a bunch is worked off over the turns that follow, each on time. After a cut there is more than
that, and it is better to be late for a while than to be behind for long.
"""

import time

from vsensor.grid import NS

SHARE = 0.5
"""Of a slot."""
GROWTH = 1.1
GROWTH_HZ = 1000.0
"""With each turn in a row that leaves samples waiting, and no faster than as many times a second: from half a
slot of 1 ms to the longest in 50 turns."""
LONGEST_S = 0.05
"""Status, commands and signals do not wait longer."""


class Ration:
    """The time that turns have for samples."""

    def __init__(self, rate_hz: float) -> None:
        self._least_ns = round(SHARE * NS / rate_hz)
        self._most_ns = max(self._least_ns, round(LONGEST_S * NS))
        self._growth = GROWTH ** min(1.0, GROWTH_HZ / rate_hz)
        self._ns = self._least_ns
        self._until_ns = 0
        self._spent = False

    def begin(self) -> None:
        """A turn begins: it has more time than the one before if that one had too little."""
        self._ns = min(round(self._growth * self._ns), self._most_ns) if self._spent else self._least_ns
        self._spent = False
        self._until_ns = time.monotonic_ns() + self._ns

    def lasts(self) -> bool:
        """Whether there is time for another sample."""
        self._spent = time.monotonic_ns() >= self._until_ns
        return not self._spent
