"""What comes below a rig's prefix, drained without waiting: surface samples, or whatever a listener hears."""

import math
import time
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

import zenoh
from zenoh.ext import (
    AdvancedSubscriber,
    HistoryConfig,
    RecoveryConfig,
    declare_advanced_subscriber,
)

from vsensor.bus.allowance import Allowance
from vsensor.messages import (
    SURFACE,
    Message,
    Sample,
    message_type,
    surface,
)

HISTORY_S = 10.0
"""Of what was sent before we came so much is asked for: a sensor that starts again need not warm up."""
MISSES_CAPACITY = 1 << 10
INBOX_CAPACITY = 1 << 16
"""Samples that may wait for a tick: 30 s of two channels at 1 kHz, past which the oldest are lost."""


@dataclass(frozen=True, slots=True)
class Received:
    """One surface sample as it came: decoded, or with what made it unreadable."""

    topic: str
    received_ns: int
    sample: Sample | None
    fault: str = ""
    over_rate: bool = False
    """It came too fast to be looked at."""


class SurfaceInbox:
    """The rig's surface channels in the order of arrival, drained without waiting."""

    def __init__(
        self,
        session: zenoh.Session,
        prefix: str,
        topics: Collection[str],
        max_rate: float = math.inf,
        most_refused: int = INBOX_CAPACITY,
    ) -> None:
        self._skip = len(prefix) + 1
        self._most_refused = most_refused
        # A backlog after a cut link is no flood: as much as waits here is let through at once.
        self._allowances = {topic: Allowance(max_rate, INBOX_CAPACITY) for topic in topics}
        self._subscriber = recovering(session, f"{prefix}/{SURFACE}", INBOX_CAPACITY)
        self._misses = self._subscriber.sample_miss_listener(zenoh.handlers.RingChannel(MISSES_CAPACITY))
        self.missed = 0
        """Samples that the bus knows to be lost: cut off for longer than the publisher's cache reaches."""
        self._waiting = 0

    def drain(self, more: Callable[[], bool] = lambda: True) -> Iterator[Received]:
        """Yield what has come since the last call, and no longer than there is time for `more`.

        Never waits, and ends even if ever more comes.
        """
        self._count_missed()
        refused = 0
        for number in range(1, INBOX_CAPACITY + 1):
            if not more() or (raw := self._subscriber.try_recv()) is None:
                return
            self._waiting = max(self._waiting, number)
            topic = str(raw.key_expr)[self._skip :]
            allowance = self._allowances.get(topic)
            if allowance is None:
                continue
            if allowance.take(time.monotonic_ns()):
                yield _decoded(topic, raw)
                continue
            yield Received(topic, time.time_ns(), None, over_rate=True)
            refused += 1
            if refused == self._most_refused:  # refusing takes time too
                return

    def most_waiting(self) -> int:
        """The most samples that one drain has taken since the last call: as many had waited, at least."""
        most, self._waiting = self._waiting, 0
        return most

    def _count_missed(self) -> None:
        while (miss := self._misses.try_recv()) is not None:
            self.missed += miss.nb


def recovering(
    session: zenoh.Session, key: str, capacity: int
) -> "AdvancedSubscriber[zenoh.handlers.Handler[zenoh.Sample]]":
    """Subscribe so that what a cut of the link held back is asked for again, from the publisher's cache.

    Samples of one publisher come in its order. A publisher without a cache is heard as by any subscriber.
    """
    return declare_advanced_subscriber(
        session,
        key,
        zenoh.handlers.RingChannel(capacity),
        history=HistoryConfig(detect_late_publishers=True, max_age=HISTORY_S),
        recovery=RecoveryConfig(heartbeat=True, periodic_queries=None),
    )


def _decoded(topic: str, raw: zenoh.Sample) -> Received:
    received_ns = time.time_ns()
    try:
        # Its size is asked first: what is far too large for a sample is not even copied.
        surface.check_size(len(raw.payload))
        sample = surface.decode(raw.payload.to_bytes(), str(raw.encoding), _time_ns(raw.timestamp))
    except ValueError as error:
        return Received(topic, received_ns, None, str(error))
    return Received(topic, received_ns, sample)


class Feed:
    """What a listener hears below a rig's prefix: of these topics, or every message we know.

    Of each topic that is named the newest `capacity` are kept while nobody drains; a flood of one pushes
    out no other's.
    """

    def __init__(
        self,
        session: zenoh.Session,
        prefix: str,
        topics: Collection[str] = ("**",),
        capacity: int = INBOX_CAPACITY,
    ) -> None:
        self._skip = len(prefix) + 1
        self._capacity = capacity
        self._subscribers = [
            session.declare_subscriber(f"{prefix}/{topic}", zenoh.handlers.RingChannel(capacity))
            for topic in topics
        ]

    def drain(self) -> Iterator[tuple[str, Message]]:
        """Yield (topic, message) of what has come since the last call, topic after topic.

        Never waits, and ends even if ever more comes; what is unreadable is passed over.
        """
        for subscriber in self._subscribers:
            yield from self._drain(subscriber)

    def _drain(
        self, subscriber: "zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]"
    ) -> Iterator[tuple[str, Message]]:
        for _ in range(self._capacity):
            if (raw := subscriber.try_recv()) is None:
                return
            topic = str(raw.key_expr)[self._skip :]
            kind = message_type(topic)
            if kind is None or str(raw.encoding) != surface.PROTOBUF:
                continue
            try:
                yield topic, kind.FromString(raw.payload.to_bytes())
            except Exception:  # noqa: S112 -- protobuf's own error type differs by backend
                continue


def _time_ns(timestamp: zenoh.Timestamp | None) -> int | None:
    return None if timestamp is None else timestamp.get_time_as_ntp64().as_nanos()
