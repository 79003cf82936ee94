"""Viewers that take nothing more.

Rerun's server waits for each of its clients: a browser's page that is frozen would hold up all who look on,
and what is not sent yet would wait in our memory without end. A frozen window is dropped by Rerun itself,
which asks it for a sign of life; a page in a browser is not asked.
"""

import fcntl
import os
import socket
import stat
import struct
import sys
import termios
from collections.abc import Iterator
from pathlib import Path

PATIENCE_S = 20.0
"""As long as Rerun gives a window."""
EVERY_S = 1.0

_TAKEN = struct.Struct("=120xQ")
"""Of the kernel's account of a connection (tcp_info, linux/tcp.h): bytes that the other end has taken."""
_WAITING = struct.Struct("=i")


class Stuck:
    """Watches the connections of a server of this process, at `port`; only on Linux it sees them."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._due_s = 0.0
        self._seen: dict[object, tuple[int, float]] = {}
        """By its address, how many bytes each has taken, and since when it is so many, s."""

    def let_go(self, now_s: float) -> int:
        """Cut off who has taken nothing for long though something waits for it; how many.

        It looks once a second, however often it is called. `now_s` is of a clock that only goes forward.
        """
        if now_s < self._due_s:
            return 0
        self._due_s = now_s + EVERY_S
        cut = 0
        before, self._seen = self._seen, {}
        for connection in _connections(self._port):
            who, taken = connection.getpeername(), _taken(connection)
            had, since_s = before.get(who, (taken, now_s))
            if taken != had or not _waiting(connection):
                since_s = now_s
            if now_s - since_s >= PATIENCE_S:
                connection.shutdown(socket.SHUT_RDWR)
                cut += 1
            else:
                self._seen[who] = taken, since_s
        return cut


def _connections(port: int) -> Iterator[socket.socket]:
    """Those of this process's sockets that serve at a port, each open until the next is asked for."""
    if sys.platform != "linux":
        return
    for file in Path("/proc/self/fd").iterdir():
        try:
            if not stat.S_ISSOCK(os.fstat(int(file.name)).st_mode):
                continue
            found = socket.socket(fileno=os.dup(int(file.name)))
        except OSError:  # it has ended since
            continue
        with found:
            if found.family in (socket.AF_INET, socket.AF_INET6) and found.type == socket.SOCK_STREAM:
                try:
                    found.getpeername()
                except OSError:  # it listens, or has ended
                    continue
                if found.getsockname()[1] == port:
                    yield found


def _taken(connection: socket.socket) -> int:
    told = connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _TAKEN.size)
    return int(_TAKEN.unpack(told)[0])


def _waiting(connection: socket.socket) -> int:
    """Bytes that the kernel holds for the other end."""
    told = fcntl.ioctl(connection, termios.TIOCOUTQ, bytes(_WAITING.size))
    return int(_WAITING.unpack(told)[0])
