"""The two ends of a bus: a daemon's session and a client's, and what an inbox between them gives out."""

import itertools
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

import zenoh

from tests.daemons import free_bus, wait_until
from vsensor.bus import Outbox, Received, SurfaceInbox, open_session
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample

CHANNELS = (SURFACE_TORQUE, SURFACE_SPEED)

_NUMBERS = itertools.count()


class Ends:
    """A rig of its own on a bus of two sessions."""

    def __init__(self, daemon: zenoh.Session, client: zenoh.Session) -> None:
        self.prefix = f"rigs/{next(_NUMBERS)}"
        self.daemon = daemon
        self.client = client
        self._outbox = Outbox(client, self.prefix, reliable=True)

    def inbox(self, topics: Collection[str] = CHANNELS, **options: Any) -> SurfaceInbox:
        """The daemon's inbox for this rig."""
        return SurfaceInbox(self.daemon, self.prefix, topics, **options)

    def send(self, topic: str, times_ns: Collection[int]) -> None:
        """Publish a channel's samples, as the rig does, and wait until all have come to the daemon."""
        for time_ns in times_ns:
            self._outbox.put(topic, Sample(time_ns=time_ns, value=1.0))
        self.flush()

    def flush(self) -> None:
        """Wait until all that was sent has come."""
        end = f"{self.prefix}/end"
        with self.daemon.declare_subscriber(end, zenoh.handlers.RingChannel(1)) as last:

            def has_come() -> bool:
                self.client.put(end, "")  # again and again: at first it may not be known who listens
                time.sleep(0.001)
                return last.try_recv() is not None

            wait_until(has_come, "the last of what was sent")


@contextmanager
def ends() -> Iterator[Ends]:
    """Both ends of a bus of their own."""
    bus = free_bus()
    with open_session(bus, "daemon") as daemon, open_session(bus, "client") as client:
        yield Ends(daemon, client)


def received(inbox: SurfaceInbox, count: int) -> list[Received]:
    """What an inbox gives out until it is so much."""
    got: list[Received] = []

    def enough() -> bool:
        got.extend(inbox.drain())
        return len(got) >= count

    wait_until(enough, f"{count} samples")
    return got


def times_ns(got: Collection[Received], topic: str) -> list[int]:
    """The times of a channel's samples, in their order."""
    return [each.sample.time_ns for each in got if each.topic == topic and each.sample is not None]
