"""What comes over the bus, as soon as there is one: the daemon may start after the view, and start again."""

import time
from collections.abc import Callable, Iterator
from typing import Self

import zenoh

from vsensor.bus import Feed, open_session
from vsensor.config import Bus
from vsensor.errors import BusError
from vsensor.messages import SENSOR_ALIVE, Message
from vsensor.view.place import ViewError
from vsensor.view.stream import TOPICS

RETRY_S = 1.0
CAPACITY = 4096
"""So many of each may wait: 40 s of ticks at 100 Hz. A view that is further behind drops the oldest."""


class Ears:
    """A client of the bus that waits for it; once there, Zenoh itself finds a restarted daemon again.

    Without a prefix it listens to the one rig whose sensor is alive.
    """

    def __init__(self, bus: Bus, prefix: str | None, say: Callable[[str], None]) -> None:
        self._bus = bus
        self._prefix = prefix
        self._say = say
        self._said = ""
        self._next_try = 0.0
        self._session: zenoh.Session | None = None
        self._feed: Feed | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._session is not None:
            self._session.close()  # type: ignore[no-untyped-call]

    def drain(self) -> Iterator[Message]:
        """Yield what has come since the last call; never waits, and takes at most what may wait."""
        if self._feed is None and time.monotonic() >= self._next_try:
            self._next_try = time.monotonic() + RETRY_S
            self._listen()
        if self._feed is not None:
            for _, message in self._feed.drain():
                yield message

    def _listen(self) -> None:
        try:
            self._session = self._session or open_session(self._bus, "client")
        except BusError as error:
            self._say_once(f"{error}; trying on")
            return
        prefix = self._prefix or self._living_rig(self._session)
        if prefix is None:
            self._say_once("no sensor is alive on the bus yet; waiting for one")
            return
        self._feed = Feed(self._session, prefix, TOPICS, CAPACITY)
        self._say_once(f"listening to {prefix}")

    def _living_rig(self, session: zenoh.Session) -> str | None:
        tokens = f"{self._bus.prefix.replace('{rig}', '*')}/{SENSOR_ALIVE}"
        replies = [reply.ok for reply in session.liveliness().get(tokens, timeout=RETRY_S)]
        prefixes = sorted({str(ok.key_expr).removesuffix(f"/{SENSOR_ALIVE}") for ok in replies if ok})
        if len(prefixes) > 1:
            raise ViewError(f"several sensors are alive on the bus: {', '.join(prefixes)}: name one by --rig")
        return prefixes[0] if prefixes else None

    def _say_once(self, text: str) -> None:
        if text != self._said:
            self._said = text
            self._say(text)
