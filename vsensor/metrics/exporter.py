"""The daemon's end of the metrics: hands each second's status over and never waits."""

import contextlib
import os
import socket
import subprocess
import sys
import threading
import time
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
AGAIN_S = 1.0
MOST_S = 60.0
"""How soon a process that has died is started again: after twice as long each time, and this at the most."""

Started = tuple[socket.socket, subprocess.Popen[bytes]]
"""Our end of the socket, and the process."""


class MetricsError(VsensorError):
    """The metrics cannot be served; the message names the address."""


class Exporter:
    """A process that serves what it was told last. It may die or hang: the daemon goes on without it.

    Where it has died, it is started again. Raises MetricsError where it cannot listen at first.
    """

    def __init__(self, metrics: Metrics) -> None:
        self.trouble = ""
        """Why nothing is served; empty while all is well."""
        self._metrics = metrics
        self._processors = os.sched_getaffinity(0)
        self._socket, self._process = _start(metrics)
        self._begun = time.monotonic()
        self._pause_s = AGAIN_S
        self._started: list[Started] = []
        self._thread: threading.Thread | None = None
        self._ending = threading.Event()
        self._socket.setblocking(False)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ending.set()
        if self._thread is not None:
            self._thread.join(END_S)
            self._take_up()
        _end(self._socket, self._process)

    @property
    def pid(self) -> int:
        """The process."""
        return self._process.pid

    def tell(self, status: Status) -> bool:
        """Hand a status over; whether it was taken. Where not, another follows in a second. Never waits."""
        self._take_up()
        try:
            self._socket.send(status.SerializeToString())
        except BlockingIOError:  # its buffer is full
            return False
        except OSError:
            self._begin_again()
            return False
        return True

    def _begin_again(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._serve_again, name="metrics", daemon=True)
            self._thread.start()

    def _serve_again(self) -> None:
        with contextlib.suppress(OSError):  # what we start is not for the loop's processor
            os.sched_setaffinity(0, self._processors)
        status = _end(self._socket, self._process)
        self.trouble = f"{_at(self._metrics)}: the process that serves them ended (exit status {status})"
        if time.monotonic() - self._begun > MOST_S:
            self._pause_s = AGAIN_S
        while not self._ending.wait(self._pause_s):
            self._pause_s = min(2 * self._pause_s, MOST_S)
            try:
                self._started.append(_start(self._metrics))
            except (MetricsError, OSError) as error:
                self.trouble = str(error)
            else:
                return

    def _take_up(self) -> None:
        """Take up with the process that was started again, once it stands ready."""
        if self._started:
            self._socket, self._process = self._started.pop()
            self._socket.setblocking(False)
            self._begun = time.monotonic()
            self._thread = None
            self.trouble = ""


def _start(metrics: Metrics) -> Started:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    command = [sys.executable, "-m", "vsensor.metrics.process"]
    with theirs:
        process = subprocess.Popen(
            [*command, str(theirs.fileno()), metrics.host, str(metrics.port)],
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
        )
    ours.settimeout(START_S)
    try:
        answer = ours.recv(WORD_BYTES)
    except TimeoutError:
        answer = f"did not start within {START_S:g} s".encode()
    if answer != READY:
        _end(ours, process)
        raise MetricsError(f"{_at(metrics)}: {answer.decode() or 'died'}")
    return ours, process


def _end(ours: socket.socket, process: "subprocess.Popen[bytes]") -> int:
    """Let go of the process and wait for its end; returns its exit status."""
    ours.close()
    with contextlib.suppress(subprocess.TimeoutExpired):
        return process.wait(END_S)
    process.kill()
    return process.wait()


def _at(metrics: Metrics) -> str:
    return f"metrics at {metrics.host}:{metrics.port}"
