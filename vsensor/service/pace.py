"""The loop's clock: absolute deadlines, so that lateness never adds up."""

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple, Protocol

from vsensor.grid import NS

LEADS_NS = (1_200_000, 400_000)
"""So long before a slot it is prepared, and once more for what has come since;"""
LEAD_SHARE = 0.4
"""by no more of a slot,"""
LEAST_LEAD_NS = 300_000
"""and where that is less than a tick may take, not at all."""
BELIEVED = 8
"""How long one tick takes is a mean of the last ones, in which each counts for an eighth,"""
FORGOTTEN = 1024
"""and less by so much each time that nothing was prepared: a spell of slowness is not for ever."""


class Clock(Protocol):
    """A monotonic clock; tests bring their own."""

    def now_ns(self) -> int:
        """Nanoseconds since some fixed moment."""

    def sleep_until(self, deadline_ns: int) -> None:
        """Return at the deadline or later, and at once when it has passed."""


class MonotonicClock:
    """The operating system's monotonic clock."""

    def now_ns(self) -> int:
        """Nanoseconds of CLOCK_MONOTONIC."""
        return time.monotonic_ns()

    def sleep_until(self, deadline_ns: int) -> None:
        """Sleep in the kernel; its timer is accurate to some fifty microseconds."""
        wait_ns = deadline_ns - time.monotonic_ns()
        if wait_ns > 0:
            time.sleep(wait_ns / NS)


class Slot(NamedTuple):
    """One turn of the loop."""

    number: int
    lateness_ns: int
    """Wake-up after the deadline: that of the first skipped slot, where some were."""
    skipped: int
    """Slots before this one that passed without a turn."""


class Pace:
    """Slots at a fixed rate on an absolute grid; of those due at once, the last alone gets a turn."""

    def __init__(self, rate_hz: float, clock: Clock, prepare: Callable[[int], int] | None = None) -> None:
        """Where `prepare` is given it is called shortly before each slot for which there is time.

        It gets a time after which it should begin nothing more: halfway to the slot, or at once where a tick
        has lately taken longer than there is. It tells how many it has run. Without time for one it is called
        all the same: a processor that was just at work wakes sooner.
        """
        self._rate = rate_hz
        self._clock = clock
        self._prepare = prepare
        self._leads_ns = _leads_ns(rate_hz)
        self._took_ns = 0
        """How long one tick took of late, as far as it was prepared."""
        self.start_ns = 0
        """Slot 0, by the clock."""

    def slots(self) -> Iterator[Slot]:
        """Yield each slot at its deadline, for as long as the caller goes on."""
        start = self.start_ns = self._clock.now_ns()
        number = 0
        while True:
            due = number + 1
            deadline = start + round(due * NS / self._rate)
            if self._prepare is not None:
                self._prepare_for(deadline, self._prepare)
            self._clock.sleep_until(deadline)
            now = self._clock.now_ns()
            number = max(due, int((now - start) * self._rate / NS))
            yield Slot(number, now - deadline, number - due)

    def _prepare_for(self, deadline: int, prepare: Callable[[int], int]) -> None:
        for lead_ns in self._leads_ns:
            ahead = deadline - lead_ns
            if self._clock.now_ns() < ahead:
                self._clock.sleep_until(ahead)
                begun = self._clock.now_ns()
                done = prepare(ahead + lead_ns // 2 if self._took_ns < lead_ns else ahead)
                self._learn(done, self._clock.now_ns() - begun)

    def _learn(self, done: int, lasted_ns: int) -> None:
        """Learn how long one tick takes from so many that were prepared, or forget some of it."""
        if not done:
            self._took_ns -= self._took_ns // FORGOTTEN
            return
        # No more than the longest time there is: a pause of the machine would be remembered for seconds.
        took = min(lasted_ns // done, self._leads_ns[0])
        self._took_ns += (took - self._took_ns) // (BELIEVED if self._took_ns else 1)


def _leads_ns(rate_hz: float) -> list[int]:
    longest = round(LEAD_SHARE * NS / rate_hz)
    leads = {min(lead, longest) for lead in LEADS_NS}
    return sorted((lead for lead in leads if lead >= LEAST_LEAD_NS), reverse=True)
