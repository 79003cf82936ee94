"""One surface channel as it comes: bounded, recovered after a cut, and seen before it is taken."""

import time
from collections import deque
from typing import NamedTuple

import zenoh
from zenoh.ext import (
    AdvancedSubscriber,
    HistoryConfig,
    RecoveryConfig,
    declare_advanced_subscriber,
)

from vsensor.bus.allowance import Allowance
from vsensor.grid import NS
from vsensor.messages import Sample, Unreadable, surface

CAPACITY = 1 << 16
"""Messages of a channel that may wait: a minute at 1 kHz, past which the oldest are lost."""
MISSES_CAPACITY = 1 << 14
HISTORY_S = 10.0
"""Of what was sent before we came so much is taken: a sensor that starts again need not warm up.

It is not asked for by age: a publisher that comes back after a cut would be asked for no more.
"""
PATIENCE_NS = NS // 2
"""Who says nothing for so long, by our clock, is silent: no other channel waits for it any longer."""
STRAY_NS = 2 * NS
"""A sample so far off the one before it in time is no part of any order: the intake judges it at once."""
AT_ONCE = -(1 << 63)
"""Before all times."""


class Received(NamedTuple):
    """One surface sample as it came: decoded, or what was unreadable of it."""

    topic: str
    received_ns: int
    sample: Sample | None
    unreadable: Unreadable | None = None
    over_rate: bool = False
    """It came too fast to be looked at."""


class SurfaceQueue:
    """One channel's samples in their order, of which the first that waits is seen before it is taken."""

    def __init__(
        self, session: zenoh.Session, prefix: str, topic: str, max_rate: float, capacity: int
    ) -> None:
        self.topic = topic
        self.waits = False
        """Whether a sample was seen that is not taken yet."""
        self.time_ns = AT_ONCE
        """When the source measured it; AT_ONCE where it has no place in the order of time."""
        self.over_rate = False
        """Whether it came too fast to be looked at."""
        self.newest_ns: int | None = None
        """When the source measured what was taken last."""
        self.held_ns = 0
        """Since when the sample that was seen is held back, by our monotonic clock; 0 where it is not."""
        self.given_up = False
        """Whether it was waited for in vain, and has not come up since."""
        self.rested = True
        """Whether the sample that was seen came after a silence."""
        self._active_ns = -PATIENCE_NS
        self._raw: zenoh.Sample
        self._sample: Sample | None = None
        self._unreadable: Unreadable | None = None
        # A backlog after a cut link is no flood: as much as waits here is let through at once.
        self._allowance = Allowance(max_rate, capacity)
        self._capacity = capacity
        self._subscriber = recovering(session, f"{prefix}/{topic}", capacity)
        self._misses = self._subscriber.sample_miss_listener(zenoh.handlers.RingChannel(MISSES_CAPACITY))
        self._history: deque[zenoh.Sample] = deque()

    def look(self, now_ns: int) -> bool:
        """Look for another sample, at a time of our monotonic clock; whether there is one."""
        raw = self._history.popleft() if self._history else self._subscriber.try_recv()
        if raw is None:
            return False
        self.rested = now_ns - self._active_ns >= PATIENCE_NS
        self._see(raw, now_ns)
        return True

    def take(self) -> Received:
        """The sample that was seen."""
        self.waits = False
        self._active_ns = time.monotonic_ns()
        if self._sample is not None:
            self.newest_ns = self._sample.time_ns
        return Received(self.topic, time.time_ns(), self._sample, self._unreadable, self.over_rate)

    def is_overtaken(self) -> bool:
        """Whether what came behind the sample that was seen is older: then it has a time of its own."""
        if not self._history and (raw := self._subscriber.try_recv()) is not None:
            self._history.append(raw)
        if not self._history:
            return False
        try:
            return self._decoded(self._history[0]).time_ns < self.time_ns
        except ValueError:
            return False

    def missed(self) -> int:
        """How many the bus knows to be lost since the last call."""
        lost = 0
        while (miss := self._misses.try_recv()) is not None:
            lost += miss.nb
        return lost

    def pass_over_history(self) -> None:
        """Pass over what was sent long before the newest that waits.

        By the publisher's own clock: ours may differ.
        """
        while len(self._history) < self._capacity and (raw := self._subscriber.try_recv()) is not None:
            self._history.append(raw)
        newest_ns = _stamp_ns(self._history[-1] if self._history else self._raw)
        if newest_ns is None:
            return
        first = self._raw
        since_ns = newest_ns - round(HISTORY_S * NS)
        while self._history and (_stamp_ns(first) or since_ns) < since_ns:
            first = self._history.popleft()
        if first is not self._raw:
            self._see(first, time.monotonic_ns())

    def _see(self, raw: zenoh.Sample, now_ns: int) -> None:
        self._raw = raw
        self.waits, self.held_ns = True, 0
        self._sample, self._unreadable, self.time_ns = None, None, AT_ONCE
        self.over_rate = not self._allowance.take(now_ns)
        if self.over_rate:
            return
        try:
            sample = self._decoded(raw)
        except ValueError as error:
            self._unreadable = self._keep(raw, str(error))
            return
        self._sample = sample
        if self.newest_ns is None or abs(sample.time_ns - self.newest_ns) <= STRAY_NS:
            self.time_ns = sample.time_ns

    def _decoded(self, raw: zenoh.Sample) -> Sample:
        # Its size is asked first: what is far too large for a sample is not even copied.
        surface.check_size(len(payload := raw.payload))
        return surface.decode(payload.to_bytes(), str(raw.encoding), lambda: _stamp_ns(raw))

    def _keep(self, raw: zenoh.Sample, fault: str) -> Unreadable:
        encoding = str(raw.encoding)
        kept = Unreadable(time_ns=time.time_ns(), channel=self.topic, encoding=encoding, fault=fault)
        if len(raw.payload) <= surface.MAX_BYTES:
            kept.payload = raw.payload.to_bytes()
        return kept


def recovering(
    session: zenoh.Session, key: str, capacity: int
) -> "AdvancedSubscriber[zenoh.handlers.Handler[zenoh.Sample]]":
    """Subscribe so that what a cut of the link held back is asked for again, from the publisher's cache.

    Samples of one publisher come in its order, all that it has kept of before we came among them. A
    publisher without a cache is heard as by any subscriber.
    """
    return declare_advanced_subscriber(
        session,
        key,
        zenoh.handlers.RingChannel(capacity),
        history=HistoryConfig(detect_late_publishers=True),
        recovery=RecoveryConfig(heartbeat=True, periodic_queries=None),
    )


def _stamp_ns(raw: zenoh.Sample) -> int | None:
    stamp = raw.timestamp
    return None if stamp is None else stamp.get_time_as_ntp64().as_nanos()
