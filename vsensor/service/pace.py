"""The loop's clock: absolute deadlines, so that lateness never adds up."""

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple, Protocol

from vsensor.grid import NS

STIR_NS = 400_000
"""A long sleep is broken so long before its end: a processor that was just at work wakes sooner."""


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

    def __init__(self, rate_hz: float, clock: Clock, stir: Callable[[], object] | None = None) -> None:
        """Where `stir` is given it is called shortly before each slot for which there is time."""
        self._rate = rate_hz
        self._clock = clock
        self._stir = stir
        self.start_ns = 0
        """Slot 0, by the clock."""

    def slots(self) -> Iterator[Slot]:
        """Yield each slot at its deadline, for as long as the caller goes on."""
        start = self.start_ns = self._clock.now_ns()
        number = 0
        while True:
            due = number + 1
            deadline = start + round(due * NS / self._rate)
            if self._stir is not None and self._clock.now_ns() < deadline - 2 * STIR_NS:
                self._clock.sleep_until(deadline - STIR_NS)
                self._stir()
            self._clock.sleep_until(deadline)
            now = self._clock.now_ns()
            number = max(due, int((now - start) * self._rate / NS))
            yield Slot(number, now - deadline, number - due)
