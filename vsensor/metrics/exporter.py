"""The daemon's end of the metrics: hands each second's status over and never waits."""

import contextlib
import socket
import subprocess
import sys
from types import TracebackType
from typing import Self

from vsensor.config import Metrics
from vsensor.errors import VsensorError
from vsensor.messages import Status

READY = b"ready"
"""What the process answers when it listens; any other answer is a complaint in plain text."""
WORD_BYTES = 1 << 16
START_S = 20.0
END_S = 2.0


class MetricsError(VsensorError):
    """The metrics cannot be served; the message names the address."""


class Exporter:
    """A process that serves what it was told last. It may die or hang: the daemon goes on without it.

    Raises MetricsError where it cannot listen.
    """

    def __init__(self, metrics: Metrics) -> None:
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "vsensor.metrics.process",
                    str(theirs.fileno()),
                    metrics.host,
                    str(metrics.port),
                ],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
            )
        self._socket.settimeout(START_S)
        try:
            answer = self._socket.recv(WORD_BYTES)
        except TimeoutError:
            answer = f"did not start within {START_S:g} s".encode()
        if answer != READY:
            self._end()
            raise MetricsError(f"metrics at {metrics.host}:{metrics.port}: {answer.decode() or 'died'}")
        self._socket.setblocking(False)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    @property
    def pid(self) -> int:
        """The process."""
        return self._process.pid

    def tell(self, status: Status) -> bool:
        """Hand a status over; whether it was taken. Where not, another follows in a second."""
        try:
            self._socket.send(status.SerializeToString())
        except OSError:  # its buffer is full, or it is gone
            return False
        return True

    def _end(self) -> None:
        self._socket.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(END_S)
            return
        self._process.kill()
        self._process.wait()
