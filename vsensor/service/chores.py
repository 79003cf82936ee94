"""What may wait, in parts: a turn that has time left does one of them.

At 2 kHz an answer takes more than half a slot, and the duties of a second in one turn five of them.
"""

from collections import deque
from collections.abc import Iterator

from vsensor.grid import NS

SPARE = 1.0
"""A turn that has spent less of its slot has time for a part: the next begins late, and is not skipped."""
PATIENCE_S = 0.02
"""For so long they are put off; then one is done all the same. Of a second's, with its ten profiles, there
are forty-five."""
PARTS_HZ = 100.0
"""So many parts a second are done, at the least, where there is time."""


class Chores:
    """Parts of what may wait, in the order in which it came."""

    def __init__(self, rate_hz: float) -> None:
        self._spare_ns = round(SPARE * NS / rate_hz)
        self._patience = int(PATIENCE_S * rate_hz)
        self._parts_a_turn = max(1, round(PARTS_HZ / rate_hz))
        self._waiting: deque[Iterator[None]] = deque()
        self._put_off = 0

    def add(self, parts: Iterator[None]) -> None:
        """Something more that may wait: what it does until each `yield`, and to its end, is a part."""
        self._waiting.append(parts)

    def turn(self, spent_ns: int) -> None:
        """Do what there is time for in a turn that has spent so much of its slot."""
        if not self._waiting:
            return
        if spent_ns > self._spare_ns and self._put_off < self._patience:
            self._put_off += 1
            return
        self._put_off = 0
        for _ in range(self._parts_a_turn):
            self._do_one()

    def finish(self) -> None:
        """Do all of it."""
        while self._waiting:
            self._do_one()

    def _do_one(self) -> None:
        if self._waiting and next(self._waiting[0], self) is self:
            self._waiting.popleft()
