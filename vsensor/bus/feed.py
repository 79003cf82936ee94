"""Whatever a listener hears below a rig's prefix, drained without waiting."""

from collections.abc import Collection, Iterator

import zenoh

from vsensor.bus.queue import CAPACITY
from vsensor.messages import Message, message_type, surface


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
        capacity: int = CAPACITY,
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
