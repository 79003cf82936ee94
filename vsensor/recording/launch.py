"""Starts the recorder's process, and starts it again where it has died."""

import contextlib
import fcntl
import json
import socket
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
from collections.abc import Collection, Mapping

from vsensor.errors import InputError, VsensorError
from vsensor.recording import wire

BUFFER_BYTES = 8 << 20
"""Asked of the kernel; without privileges it grants net.core.wmem_max (usually 208 KiB: 0.3 s at 1 kHz)."""

START_S = 20.0
"""A process that is not ready by then will not be."""

AGAIN_S = 2.0
"""How soon after its death, or after another attempt, it is started again."""

Started = tuple[socket.socket, subprocess.Popen[bytes]]
"""Our end of the socket, and the process."""

_SO_SNDBUFFORCE = 32  # linux/socket.h; Python does not name it


def launch(order: Mapping[str, object], processors: Collection[int]) -> Started:
    """Start the process with its order, and wait until it is ready.

    Raises InputError with what it complains of, VsensorError where it says nothing.
    """
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    _enlarge(ours)
    with theirs, tempfile.TemporaryFile() as stdin:
        stdin.write(json.dumps(order).encode())
        stdin.seek(0)
        # A session (setsid) of its own: Ctrl-C at the terminal must not end the recorder before
        # the daemon has said its last. -P keeps the folder we run in off its module path.
        process = subprocess.Popen(
            [
                *(sys.executable, "-P", "-m", "vsensor.recording.process"),
                *(str(theirs.fileno()), ",".join(map(str, processors))),
            ],
            stdin=stdin,
            stdout=subprocess.DEVNULL,
            pass_fds=(theirs.fileno(),),
            start_new_session=True,
        )
    try:
        _await_ready(ours, str(order["path"]))
    except BaseException:
        ours.close()
        process.kill()
        process.wait()
        raise
    ours.setblocking(False)
    return ours, process


class Relaunch:
    """Starts the process again in a thread of its own, so that the loop need not wait for it."""

    def __init__(self, order: Mapping[str, object], processors: Collection[int]) -> None:
        self._order = {**order, "begin": False}  # it begins a file when it is told what the sensor remembers
        self._processors = processors
        self._not_before = time.monotonic() + AGAIN_S
        self._thread: threading.Thread | None = None
        self._started: list[Started] = []

    def look(self) -> Started | None:
        """The process, once it stands ready; never waits."""
        if self._thread is None and time.monotonic() >= self._not_before:
            self._thread = threading.Thread(target=self._launch, daemon=True)
            self._thread.start()
        elif self._thread is not None and not self._thread.is_alive():
            self._thread = None
            self._not_before = time.monotonic() + AGAIN_S
        return self._started.pop() if self._started else None

    def close(self) -> None:
        """End what was started and not fetched: it has nothing to write."""
        if self._thread is not None:
            self._thread.join()
        for ours, process in self._started:
            ours.close()
            process.wait()

    def _launch(self) -> None:
        with contextlib.suppress(VsensorError, OSError):  # tried again
            self._started.append(launch(self._order, self._processors))


def waiting(ours: socket.socket) -> dict[str, int]:
    """What lies in the socket, and how much of that there may be, both by the kernel's own count."""
    with contextlib.suppress(OSError):
        queued = fcntl.ioctl(ours, termios.TIOCOUTQ, struct.pack("i", 0))
        limit = ours.getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF)
        return {
            "recorder_queue_bytes": struct.unpack("i", queued)[0],
            "recorder_queue_limit_bytes": limit,
        }
    return {}


def _await_ready(ours: socket.socket, path: str) -> None:
    ours.settimeout(START_S)
    try:
        answer = ours.recv(wire.PACKET_BYTES).decode()
    except TimeoutError as error:
        raise VsensorError(f"{path}: the recorder was not ready within {START_S:g} s") from error
    if not answer:
        raise VsensorError(f"{path}: the recorder ended at once; it said why above")
    if answer != wire.READY:
        raise InputError(answer)


def _enlarge(ours: socket.socket) -> None:
    try:
        ours.setsockopt(socket.SOL_SOCKET, _SO_SNDBUFFORCE, BUFFER_BYTES)
    except PermissionError:
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
