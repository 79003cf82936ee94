"""A link that can be cut: a proxy between a client and the bus."""

import contextlib
import select
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from vsensor.config import Bus


class Link:
    """Forwards to an endpoint's port, until it is cut."""

    def __init__(self, to: Bus) -> None:
        self._to = int(to.listen[0].rpartition(":")[2])
        self._door = socket.create_server(("127.0.0.1", 0))
        self._pairs: list[tuple[socket.socket, socket.socket]] = []
        self._cut = threading.Event()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def bus(self) -> Bus:
        """As a client reaches the bus over this link."""
        return Bus(connect=(f"tcp/127.0.0.1:{self._door.getsockname()[1]}",))

    def cut(self) -> None:
        """Break all connections, and let no new one through."""
        self._cut.set()

    def mend(self) -> None:
        """Let connections through again."""
        self._cut.clear()

    def close(self) -> None:
        """End it."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        with self._door:
            while not self._ended.is_set():
                if self._cut.is_set():
                    self._break()
                ends = {one: other for pair in self._pairs for one, other in (pair, pair[::-1])}
                ready, _, _ = select.select([self._door, *ends], [], [], 0.02)
                for one in ready:
                    if one is self._door:
                        self._join()
                    else:
                        self._forward(one, ends[one])
            self._break()

    def _join(self) -> None:
        client, _ = self._door.accept()
        if self._cut.is_set():
            client.close()
            return
        try:
            self._pairs.append((client, socket.create_connection(("127.0.0.1", self._to))))
        except OSError:
            client.close()

    def _forward(self, one: socket.socket, other: socket.socket) -> None:
        data = b""
        with contextlib.suppress(OSError):
            if data := one.recv(1 << 16):
                other.sendall(data)
        if not data:
            self._pairs = [pair for pair in self._pairs if one not in pair]
            one.close()
            other.close()

    def _break(self) -> None:
        for pair in self._pairs:
            for end in pair:
                end.close()
        self._pairs.clear()


@contextmanager
def link(to: Bus) -> Iterator[Link]:
    """A link to a bus, for as long as it is needed."""
    made = Link(to)
    try:
        yield made
    finally:
        made.close()
