"""The daemon's end of the recorder: hands messages over and never waits.

The session is written by a process of its own, so that neither a slow disk nor the compression of
a chunk nor a crash over there can hold the loop. Between the two lies a socket whose buffer in the
kernel is the bounded queue: what it cannot take at once is dropped and counted.
"""

import contextlib
import json
import socket
import subprocess
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from vsensor.messages import State, message_type
from vsensor.recording import wire
from vsensor.recording.launch import Relaunch, launch, waiting
from vsensor.recording.limits import NO_LIMITS, Limits
from vsensor.recording.names import session_path
from vsensor.recording.writer import Compression

Note = tuple[str, bool, str]
"""Something that the recorder did: an event's name, whether it begins, and in words."""


class Recorder:
    """A recording under way: `offer` each message, `send` once per slot of the loop, `close` at the end.

    It writes into `path` at once, or where it is not to `begin`, waits for the order. Its process runs on
    `processors`, by default on those of the caller. Raises InputError where the session cannot be created.
    Not for several threads at once.
    """

    def __init__(
        self,
        path: Path,
        *,
        configuration: str,
        metadata: Mapping[str, str],
        compression: Compression,
        limits: Limits = NO_LIMITS,
        begin: bool = True,
        processors: Collection[int] = (),
    ) -> None:
        self.path = str(path) if begin else ""
        """The file that is being written; empty where none is."""
        self.complete: list[str] = []
        """Those that were completed, as far as it has told."""
        self.figures: Mapping[str, float] = {}
        """How much waits for it, and what it tells of itself, by the names of the status' fields."""
        self.wants = False
        """Whether it wants to know what the sensor remembers: see `checkpoint`."""
        self.sent = 0
        """Messages that the kernel took."""
        self.unsent = 0
        """Messages that it did not take, or that nobody was there to take."""
        self.alive = True
        """Whether the recorder's process is there."""
        self._folder = path.parent
        self._rig = metadata.get("rig", "")
        self._states = wire.Carrier()
        self._lost = 0
        self._notes: list[Note] = []
        self._packet: list[bytes] = []
        self._bytes = 0
        self._count = 0
        self._names: dict[str, bytes] = {}
        self._trouble = ""
        self._wanted = begin
        self._lost_before = 0
        self._relaunch: Relaunch | None = None
        self._resumes = False
        self._orders = 0
        self._processors = processors
        self._heading = wire.Heading(configuration, metadata)
        self._untold = False
        self._order = {
            "path": str(path),
            "begin": begin,
            **self._heading._asdict(),
            "compression": compression,
            "limits": asdict(limits),
        }
        self._socket, self._process = launch(self._order, processors)

    @property
    def dropped(self) -> int:
        """Messages that are in no file though they should be: not taken, or lost on the recorder's side."""
        return self.unsent + self._lost_before + self._lost

    def offer(self, topic: str, data: bytes, log_time_ns: int, publish_time_ns: int) -> None:
        """Add a message to this slot's packet; one of a topic that has no schema counts as dropped."""
        name = self._names.get(topic)
        if name is None:
            name = self._name(topic)
        size = wire.HEAD.size + len(name) + len(data)
        if self._bytes + size > wire.PACKET_BYTES or not name:
            self._offer_apart(topic, name, data, log_time_ns, publish_time_ns)
            return
        self._packet += (wire.HEAD.pack(len(name), len(data), log_time_ns, publish_time_ns), name, data)
        self._bytes += size
        self._count += 1

    def send(self) -> None:
        """Hand over what was offered since the last call: one system call, which never waits."""
        if not self._count:
            return
        if self.alive and self._handed_over():
            self.sent += self._count
        else:
            self.unsent += self._count
        self._packet.clear()
        self._bytes = self._count = 0

    @property
    def pid(self) -> int:
        """The recorder's process."""
        return self._process.pid

    def next_path(self, kind: str = "") -> str:
        """A name for a file that begins now; `kind` is a word in it."""
        return str(session_path(self._folder, self._rig, kind))

    def checkpoint(self, order: str, path: str, state: State, arrays: Sequence[memoryview]) -> bool:
        """Hand over what the sensor remembers, with an order: start, split or keep.

        `path` names the file that begins with it; where empty, the recorder finds a name. `arrays` are those
        of the state, which is sent without them. Whether it was taken; never waits.
        """
        self.send()
        if not self.alive:
            return False
        if order == wire.KEEP and self._resumes and self._wanted:
            order = wire.START
        words = {"order": order, "path": path, "dropped": self.unsent, "orders": self._orders + 1}
        try:
            self._states.send(self._socket, words, time.time_ns(), state, arrays)
        except OSError:
            return False
        self._orders += 1
        self.wants = self._resumes = False
        return True

    def order(self, order: str, path: str = "", seconds: float = 0.0) -> bool:
        """Give an order without a state: stop, or snapshot of the last `seconds`; whether it was taken."""
        self.send()
        words = {"order": order, "path": path, "seconds": seconds, "dropped": self.unsent}
        try:
            self._socket.send(wire.packed_order({**words, "orders": self._orders + 1}, time.time_ns()))
        except OSError:
            return False
        self._orders += 1
        return True

    def describe(self, configuration: str, metadata: Mapping[str, str]) -> None:
        """Have files that begin from now on say this; of the metadata what is new. Never waits."""
        self._heading = wire.Heading(configuration, {**self._heading.metadata, **metadata})
        self._order |= self._heading._asdict()
        self._untold = True
        self._tell_heading()

    def look(self) -> list[Note]:
        """Hear the news, and return what has happened since; once a second will do. Never waits."""
        self._revive()
        self._tell_heading()
        while self.alive:
            try:
                news = self._socket.recv(wire.PACKET_BYTES).decode()
            except BlockingIOError:
                break
            except OSError:
                news = ""
            if news:
                with contextlib.suppress(ValueError):  # cut off, by outlandish names: the loop goes on
                    self._hear(json.loads(news))
            else:
                self._bury()
        self.figures = {**self.figures, **waiting(self._socket)}
        notes, self._notes = self._notes, []
        return notes

    def trouble(self) -> str:
        """What keeps the recorder from recording, in plain text; empty while all is well."""
        return self._trouble

    def _tell_heading(self) -> None:
        with contextlib.suppress(OSError):  # told at the next look
            if self._untold:
                wire.send_heading(self._socket, self._heading, time.time_ns())
                self._untold = False

    def _hear(self, news: dict[str, Any]) -> None:
        if news["orders"] == self._orders:  # else it was said before the last order had arrived
            self.path = news["path"]
        self.figures = news["figures"]
        self.wants = news["wants"]
        self.complete += news["complete"]
        self._trouble = news["trouble"]
        self._wanted = news["wanted"]
        self._lost = news["lost"]
        self._states.read = news["state"]
        self._notes += [(name, begins, text) for name, begins, text in news["events"]]

    def _bury(self) -> None:
        if self.alive:
            self.alive = False
            self._trouble = self._obituary()
            self._notes.append(("recording", False, self._trouble))
            self.path = ""
            if self._process.poll() != 0:  # where it was told to end, it stays so
                self._relaunch = Relaunch(self._order, self._processors)

    def _revive(self) -> None:
        """Take up with another process, where the first has died and it stands ready."""
        started = self._relaunch.look() if self._relaunch is not None else None
        if started is None:
            return
        self._socket.close()
        self._states.close()
        self._socket, self._process = started
        self._states = wire.Carrier()
        self._lost_before, self._lost = self._lost_before + self._lost, 0
        self._relaunch = None
        self._trouble = ""
        self.alive = self.wants = self._resumes = True

    def close(self, timeout: float) -> bool:
        """End the recording; whether the file was completed within `timeout` seconds.

        A recorder that takes longer is left to finish by itself; calling again waits again.
        """
        deadline = time.monotonic() + timeout
        if self._relaunch is not None:
            self._relaunch.close()
        self.send()
        self._say_farewell(timeout)
        try:
            status = self._process.wait(max(deadline - time.monotonic(), 0.0))
        except subprocess.TimeoutExpired:
            self._trouble = f"{self.path}: is still being written by process {self.pid}"
            return False
        self._hear_last()
        if status:
            self._trouble = self._trouble or self._obituary()
        self._socket.close()
        self._states.close()
        return status == 0

    def _say_farewell(self, timeout: float) -> None:
        with contextlib.suppress(OSError):  # without it the session's own figures tell less, no more
            if self.alive:
                self._socket.settimeout(timeout)
                self._socket.send(wire.packed_order({"order": wire.FAREWELL, "dropped": self.unsent}, 0))
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_WR)
        self.alive = False

    def _hear_last(self) -> None:
        with contextlib.suppress(OSError):
            while news := self._socket.recv(wire.PACKET_BYTES, socket.MSG_DONTWAIT):
                self._hear(json.loads(news))

    def _name(self, topic: str) -> bytes:
        self._names[topic] = b"" if message_type(topic) is None else topic.encode()
        return self._names[topic]

    def _offer_apart(self, topic: str, name: bytes, data: bytes, log_ns: int, publish_ns: int) -> None:
        if not name or wire.HEAD.size + len(name) + len(data) > wire.PACKET_BYTES:
            self.unsent += 1
            return
        self.send()
        self.offer(topic, data, log_ns, publish_ns)

    def _handed_over(self) -> bool:
        try:
            self._socket.send(b"".join(self._packet))
        except (BrokenPipeError, ConnectionResetError):
            self._hear_last()
            self._bury()
            return False
        except OSError:  # the buffer is full, or the kernel has no memory to spare
            return False
        return True

    def _obituary(self) -> str:
        ended = f"the recorder ended (exit status {self._process.poll()})"
        if not self.path:
            return ended
        return f"{self.path}: {ended}; what it wrote can be had by: vsensor recover {self.path}.part"
