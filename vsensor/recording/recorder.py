"""The daemon's end of the recorder: hands messages over and never waits.

The session is written by a process of its own, so that neither a slow disk nor the compression of
a chunk nor a crash over there can hold the loop. Between the two lies a socket whose buffer in the
kernel is the bounded queue: what it cannot take at once is dropped and counted.
"""

import contextlib
import json
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Collection, Mapping
from pathlib import Path

from vsensor.errors import InputError, VsensorError
from vsensor.messages import message_type
from vsensor.recording import wire
from vsensor.recording.writer import Compression

BUFFER_BYTES = 8 << 20
"""Asked of the kernel; without privileges it grants net.core.wmem_max (usually 208 KiB: 0.3 s at 1 kHz)."""

START_S = 20.0
"""A process that is not ready by then will not be."""

_SO_SNDBUFFORCE = 32  # linux/socket.h; Python does not name it


class Recorder:
    """A recording under way: `offer` each message, `send` once per slot of the loop, `close` at the end.

    Its process runs on `processors`, by default on those of the caller. Raises InputError where the
    session cannot be created. Not for several threads at once.
    """

    def __init__(
        self,
        path: Path,
        *,
        configuration: str,
        metadata: Mapping[str, str],
        compression: Compression,
        processors: Collection[int] = (),
    ) -> None:
        self.path = str(path)
        self.sent = 0
        """Messages that the kernel took."""
        self.dropped = 0
        """Messages that it did not take, or that nobody was there to take."""
        self.alive = True
        """Whether the recorder still records."""
        self._packet = bytearray(wire.PACKET_BYTES)
        self._view = memoryview(self._packet)
        self._end = 0
        self._count = 0
        self._names: dict[str, bytes] = {}
        self._trouble = ""
        order = {
            "path": self.path,
            "configuration": configuration,
            "metadata": dict(metadata),
            "compression": compression,
        }
        self._socket, self._process = _start(order, processors)

    def offer(self, topic: str, data: bytes, log_time_ns: int, publish_time_ns: int) -> None:
        """Add a message to this slot's packet; one of a topic that has no schema counts as dropped."""
        name = self._names.get(topic)
        if name is None:
            name = self._name(topic)
        at = self._end + wire.HEAD.size
        end = at + len(name) + len(data)
        if end > wire.PACKET_BYTES or not name:
            self._offer_apart(topic, name, data, log_time_ns, publish_time_ns)
            return
        wire.HEAD.pack_into(self._packet, self._end, len(name), len(data), log_time_ns, publish_time_ns)
        self._view[at:end] = name + data
        self._end = end
        self._count += 1

    def send(self) -> None:
        """Hand over what was offered since the last call: one system call, which never waits."""
        if not self._count:
            return
        if self.alive and self._handed_over():
            self.sent += self._count
        else:
            self.dropped += self._count
        self._end = 0
        self._count = 0

    @property
    def pid(self) -> int:
        """The recorder's process."""
        return self._process.pid

    def trouble(self) -> str:
        """What keeps the recorder from recording, in plain text; empty while all is well.

        Never waits; costs a system call, so ask once a second rather than at every tick.
        """
        if self.alive:
            try:
                complaint = self._socket.recv(wire.PACKET_BYTES).decode()
            except BlockingIOError:
                return ""
            except OSError:
                complaint = ""
            self.alive = False
            self._trouble = complaint or self._obituary()
        return self._trouble

    def close(self, timeout: float) -> bool:
        """End the recording; whether the file was completed within `timeout` seconds.

        A recorder that takes longer is left to finish by itself; calling again waits again.
        """
        deadline = time.monotonic() + timeout
        self.send()
        self._say_farewell(timeout)
        try:
            status = self._process.wait(max(deadline - time.monotonic(), 0.0))
        except subprocess.TimeoutExpired:
            self._trouble = f"{self.path}: is still being written by process {self.pid}"
            return False
        self._trouble = "" if status == 0 else self._last_words() or self._obituary()
        self._socket.close()
        return status == 0

    def _say_farewell(self, timeout: float) -> None:
        farewell = wire.COUNT.pack(self.dropped)
        with contextlib.suppress(OSError):  # without it the session's own figures tell less, no more
            if self.alive:
                self._socket.settimeout(timeout)
                self._socket.send(wire.HEAD.pack(0, len(farewell), 0, 0) + farewell)
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_WR)
        self.alive = False

    def _last_words(self) -> str:
        with contextlib.suppress(OSError):
            if words := self._socket.recv(wire.PACKET_BYTES, socket.MSG_DONTWAIT):
                return words.decode()
        return self._trouble

    def _name(self, topic: str) -> bytes:
        self._names[topic] = b"" if message_type(topic) is None else topic.encode()
        return self._names[topic]

    def _offer_apart(self, topic: str, name: bytes, data: bytes, log_ns: int, publish_ns: int) -> None:
        if not name or wire.HEAD.size + len(name) + len(data) > wire.PACKET_BYTES:
            self.dropped += 1
            return
        self.send()
        self.offer(topic, data, log_ns, publish_ns)

    def _handed_over(self) -> bool:
        try:
            self._socket.send(self._view[: self._end])
        except (BrokenPipeError, ConnectionResetError):
            self.alive = False
            self._trouble = self._obituary()
            return False
        except OSError:  # the buffer is full, or the kernel has no memory to spare
            return False
        return True

    def _obituary(self) -> str:
        return (
            f"{self.path}: the recorder ended (exit status {self._process.poll()}); "
            f"what it wrote can be had by: vsensor recover {self.path}.part"
        )


def _start(
    order: Mapping[str, object], processors: Collection[int]
) -> tuple[socket.socket, subprocess.Popen[bytes]]:
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
