"""The rig's surface channels drained without waiting, each in a place of its own and all in step."""

import math
import time
from collections.abc import Callable, Collection, Iterator
from operator import attrgetter

import zenoh

from vsensor.bus.queue import AT_ONCE, CAPACITY, PATIENCE_NS, Received, SurfaceQueue
from vsensor.grid import NS
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE

ABREAST = (SURFACE_TORQUE, SURFACE_SPEED)
MAX_LEAD_S = 0.25

_TIME = attrgetter("time_ns")


class SurfaceInbox:
    """The rig's surface channels, drained without waiting.

    Each has a place of its own, where `capacity` samples may wait: a flood of one takes nothing from
    another. Of those that wait the oldest comes first, by the source's time. Torque and speed come
    abreast: where one is more than `max_lead_s` ahead, and the other has nothing, it is held back until the
    other speaks or is known to be silent. After a cut, or a start, the one's backlog arrives before the
    other's, and would look like the other's silence.
    """

    def __init__(
        self,
        session: zenoh.Session,
        prefix: str,
        topics: Collection[str],
        max_rate: float = math.inf,
        most_refused: int = CAPACITY,
        *,
        max_lead_s: float = MAX_LEAD_S,
        capacity: int = CAPACITY,
    ) -> None:
        self._most_refused = most_refused
        self._max_lead_ns = round(max_lead_s * NS)
        self._capacity = capacity
        self._queues = [
            SurfaceQueue(session, prefix, topic, max_rate=max_rate, capacity=capacity) for topic in topics
        ]
        abreast = [queue for queue in self._queues if queue.topic in ABREAST]
        self._others = dict(zip(abreast, reversed(abreast), strict=True)) if len(abreast) > 1 else {}
        self._unheard = set(self._queues)
        self._missed = 0
        self._waiting = 0

    def drain(self, more: Callable[[], bool] = lambda: True, *, hold: bool = True) -> Iterator[Received]:
        """Yield what has come since the last call, and no longer than there is time for `more`.

        Asks for `more` only where something waits; what there is no time for is not lost. Never waits, and
        ends even if ever more comes. Without `hold` nothing is held back.
        """
        queues, refused = self._queues, 0
        for number in range(1, self._capacity + 1):
            now_ns = time.monotonic_ns()
            queues = [queue for queue in queues if queue.waits or queue.look(now_ns)]
            if not queues or (queue := self._next(queues, now_ns, hold)) is None or not more():
                return
            self._waiting = max(self._waiting, number)
            if queue.over_rate:
                refused += 1
                if refused >= self._most_refused:  # refusing takes time too
                    queues = [other for other in queues if other is not queue]
            yield queue.take()

    @property
    def missed(self) -> int:
        """Samples that the bus knows to be lost: cut off for longer than the publisher's cache reaches."""
        self._missed += sum(queue.missed() for queue in self._queues)
        return self._missed

    def most_waiting(self) -> int:
        """The most samples that one drain has taken since the last call: as many had waited, at least."""
        most, self._waiting = self._waiting, 0
        return most

    def _next(self, waiting: list[SurfaceQueue], now_ns: int, hold: bool) -> SurfaceQueue | None:
        """The one of these that goes next; None where it is held back."""
        queue = min(waiting, key=_TIME) if len(waiting) > 1 else waiting[0]
        if hold and self._is_ahead(queue) and self._waits(queue, now_ns):
            return None
        if queue in self._unheard:
            self._unheard.remove(queue)
            queue.pass_over_history()
            return self._next(waiting, now_ns, hold)
        return queue

    def _is_ahead(self, queue: SurfaceQueue) -> bool:
        other = self._others.get(queue)
        if other is None or other.waits or queue.time_ns == AT_ONCE:
            return False
        if other.newest_ns is None or queue.time_ns - other.newest_ns > self._max_lead_ns:
            return True
        other.given_up = False
        return False

    def _waits(self, queue: SurfaceQueue, now_ns: int) -> bool:
        """Whether there is hope that the other comes too."""
        other = self._others[queue]
        if queue.rested:  # both were cut off: the other may come back as well
            other.given_up = queue.rested = False
        if other.given_up:
            return False
        if queue.is_overtaken():  # it is ahead of its own channel, not of the other
            return False
        queue.held_ns = queue.held_ns or now_ns
        other.given_up = now_ns - queue.held_ns >= PATIENCE_NS
        return not other.given_up
