"""What we publish below a rig's prefix, kept for those who were cut off."""

import zenoh
from zenoh.ext import (
    AdvancedPublisher,
    CacheConfig,
    MissDetectionConfig,
    declare_advanced_publisher,
)

from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    STRING_PROFILE,
    SURFACE_TOPICS,
    Message,
    surface,
)

CACHE = 1 << 12
"""Messages of a topic that are kept for those who were cut off: 40 s at 100 Hz, 4 s at 1 kHz."""
SELDOM = {STRING_PROFILE: 100, SENSOR_STATUS: 60, SENSOR_EVENT: 1000}
"""Topics that are larger, or come less often."""
SURFACE_CACHE = 1 << 14
"""A rig keeps more: 16 s at 1 kHz, and both channels of it find room in the inbox."""
AWAITED = (*SURFACE_TOPICS, BIT_ESTIMATE)
"""Others wait for these: each goes out at once. What else there is goes out with the next of them, or a
millisecond later: a sender that is woken for every message and every listener takes the loop's time."""
HEARTBEAT_S = 0.5
"""How often a publisher tells what it sent last, so that a lost end is noticed."""


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
                express=topic in AWAITED,
                cache=CacheConfig(min(self._cache, SELDOM.get(topic, self._cache))),
                sample_miss_detection=MissDetectionConfig(heartbeat=HEARTBEAT_S, sporadic_heartbeat=None),
                publisher_detection=True,
            )
        return self._publishers[topic]
