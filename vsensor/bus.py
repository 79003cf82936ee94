"""Zenoh: sessions that stay on this machine unless told otherwise, and typed traffic over them."""

import math
import time
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

import zenoh
from zenoh.ext import (
    AdvancedPublisher,
    AdvancedSubscriber,
    CacheConfig,
    HistoryConfig,
    MissDetectionConfig,
    RecoveryConfig,
    declare_advanced_publisher,
    declare_advanced_subscriber,
)

from vsensor.access import Role, is_locked, without_place, zenoh_config
from vsensor.allowance import Allowance
from vsensor.config import Bus
from vsensor.errors import BusError
from vsensor.messages import (
    SENSOR_ALIVE,
    SENSOR_COMMAND,
    SENSOR_EVENT,
    SENSOR_STATUS,
    STRING_PROFILE,
    SURFACE,
    Message,
    Sample,
    Status,
    message_type,
    surface,
)

CACHE = 1 << 12
"""Messages of a topic that are kept for those who were cut off: 40 s at 100 Hz, 4 s at 1 kHz."""
SELDOM = {STRING_PROFILE: 100, SENSOR_STATUS: 60, SENSOR_EVENT: 1000}
"""Topics that are larger, or come less often."""
SURFACE_CACHE = 1 << 14
"""A rig keeps more: 16 s at 1 kHz, and both channels of it find room in the inbox."""
HEARTBEAT_S = 0.5
"""How often a publisher tells what it sent last, so that a lost end is noticed."""
HISTORY_S = 10.0
"""Of what was sent before we came so much is asked for: a sensor that starts again need not warm up."""
MISSES_CAPACITY = 1 << 10
QUESTIONS_CAPACITY = 16
"""Of more that come at once the oldest go unanswered."""
QUESTION_BYTES = 200
"""What a driller may say is far shorter."""
INBOX_CAPACITY = 1 << 16
"""Samples that may wait for a tick: 30 s of two channels at 1 kHz, past which the oldest are lost."""

ANSWER_S = 5.0
"""A sensor that has not answered by then does not."""


def open_session(bus: Bus, role: Role) -> zenoh.Session:
    """Open a session: the daemon listens and routes among its clients; a client connects to it.

    Use it in a `with`: a session left open keeps the process from ending. Raises BusError, and
    ConfigError where the file of Zenoh's own settings, or a secret, cannot be used.
    """
    config = zenoh_config(bus, role)
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        ends = ", ".join(bus.listen if role == "daemon" else bus.connect or bus.listen)
        raise BusError(f"no bus at {ends}: {_hint(config, role)} ({without_place(error)})") from error


def _hint(config: zenoh.Config, role: Role) -> str:
    if role == "daemon":
        return "is the port taken?"
    proof = " Does it take our certificate, our user and password?" if is_locked(config) else ""
    return f"is the daemon (vsensor run) up? Is this its address?{proof}"


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

    def drain(self, more: Callable[[], bool] = lambda: True) -> Iterator[Received]:
        """Yield what has come since the last call, and no longer than there is time for `more`.

        Never waits, and ends even if ever more comes.
        """
        self._count_missed()
        refused = 0
        for _ in range(INBOX_CAPACITY):
            if not more() or (raw := self._subscriber.try_recv()) is None:
                return
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


class Questions:
    """Questions put to the sensor, to tell or to do something, drained without waiting.

    The loop answers them itself: another thread would hold the interpreter while the loop is due.
    """

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._queryable = session.declare_queryable(key, zenoh.handlers.RingChannel(QUESTIONS_CAPACITY))

    def answer(self, reply: Callable[[str], str | bytes], encoding: str = surface.TEXT) -> None:
        """Answer what has come since the last call: `reply` returns the answer, or raises ValueError."""
        for _ in range(QUESTIONS_CAPACITY):
            if (query := self._queryable.try_recv()) is None:
                return
            with query:
                words = b"" if query.payload is None else query.payload.to_bytes()[:QUESTION_BYTES]
                try:
                    query.reply(query.key_expr, reply(words.decode("utf-8", "replace")), encoding=encoding)
                except ValueError as error:
                    query.reply_err(str(error))


def command(session: zenoh.Session, prefix: str, words: str) -> str:
    """Tell a sensor something; returns what it did. Raises BusError where it refuses or does not answer."""
    for reply in session.get(f"{prefix}/{SENSOR_COMMAND}", payload=words, timeout=ANSWER_S):
        if reply.ok is not None:
            return reply.ok.payload.to_string()
        if reply.err is not None:
            raise BusError(reply.err.payload.to_string())
    raise BusError(f"no sensor answers at {prefix}/{SENSOR_COMMAND}: is the daemon (vsensor run) up?")


def ask_status(session: zenoh.Session, prefix: str) -> Status:
    """A sensor's status of this second. Raises BusError where none answers."""
    for reply in session.get(f"{prefix}/{SENSOR_STATUS}", timeout=ANSWER_S):
        if reply.ok is not None:
            return Status.FromString(reply.ok.payload.to_bytes())
    raise BusError(f"no sensor answers at {prefix}/{SENSOR_STATUS}: is the daemon (vsensor run) up?")


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


class Outbox:
    """Publishers below a rig's prefix, each declared at its first message.

    `reliable` waits where the network is slow (a rig or replay, which must not lose a sample);
    without it a message that cannot be sent is dropped (the daemon, which must not wait). The last
    `cache` messages of each topic are kept for those who were cut off (`recovering`).
    """

    def __init__(self, session: zenoh.Session, prefix: str, *, reliable: bool, cache: int = CACHE) -> None:
        self._session = session
        self._cache = cache
        self._prefix = prefix
        self._congestion = zenoh.CongestionControl.BLOCK if reliable else zenoh.CongestionControl.DROP
        self._publishers: dict[str, AdvancedPublisher] = {}
        self.muted = False
        """Nothing goes out: another speaks."""

    def put(self, topic: str, message: Message) -> bytes:
        """Publish a message; returns its bytes, which the recorder stores as they went out."""
        data = message.SerializeToString()
        if not self.muted:
            self._publisher(topic).put(data)
        return data

    def _publisher(self, topic: str) -> AdvancedPublisher:
        if topic not in self._publishers:
            self._publishers[topic] = declare_advanced_publisher(
                self._session,
                f"{self._prefix}/{topic}",
                encoding=surface.PROTOBUF,
                congestion_control=self._congestion,
                express=True,
                cache=CacheConfig(min(self._cache, SELDOM.get(topic, self._cache))),
                sample_miss_detection=MissDetectionConfig(heartbeat=HEARTBEAT_S, sporadic_heartbeat=None),
                publisher_detection=True,
            )
        return self._publishers[topic]


def _time_ns(timestamp: zenoh.Timestamp | None) -> int | None:
    return None if timestamp is None else timestamp.get_time_as_ntp64().as_nanos()


def wait_for_sensor(session: zenoh.Session, prefix: str, timeout_s: float = 10.0) -> bool:
    """Wait until a daemon says that it listens below this prefix; False when none does in time."""
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        for reply in session.liveliness().get(f"{prefix}/{SENSOR_ALIVE}", timeout=1.0):
            if reply.ok is not None:
                return True
        time.sleep(0.1)
    return False
