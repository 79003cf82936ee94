"""The recorder's process: takes packets off the socket at once, writes them to the disk in its own time.

Started by `recorder.Recorder` as `python -m vsensor.recording.process FD PROCESSORS`, with what to write
(the arguments of SessionWriter) as JSON on its standard input. Ends when the daemon closes the socket or
dies: either way the file is completed.
"""

import contextlib
import json
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Collection, Iterable
from pathlib import Path

from vsensor.errors import VsensorError
from vsensor.recording import wire
from vsensor.recording.writer import RECORDER, SessionWriter

BACKLOG_BYTES = 64 << 20
"""What may wait for a disk that does not answer: a minute and more at 1 kHz."""

SYNC_S = 1.0
"""At most this much is lost in a power cut."""

_LOOK_S = 0.05  # often enough to keep the backlog short, seldom enough to cost nothing


class Backlog:
    """Packets between the thread that receives and the one that writes, bounded in bytes."""

    def __init__(self, capacity: int) -> None:
        self.dropped = 0
        """Messages, not packets."""
        self.ended = threading.Event()
        self._capacity = capacity
        self._held = 0
        self._packets: list[bytes] = []
        self._lock = threading.Lock()

    def put(self, packet: bytes) -> None:
        """Add a packet, or count its messages as dropped where there is no room."""
        with self._lock:
            if self._held + len(packet) <= self._capacity:
                self._packets.append(packet)
                self._held += len(packet)
                return
        self.dropped += sum(1 for _ in wire.unpack(packet))

    def take(self) -> list[bytes]:
        """Take all that is there, in order."""
        with self._lock:
            packets, self._packets, self._held = self._packets, [], 0
        return packets


class Clerk:
    """Writes packets into the session; where the disk refuses, complains once and counts."""

    def __init__(self, writer: SessionWriter, socket_: socket.socket) -> None:
        self.failed = False
        self._writer = writer
        self._socket = socket_
        self._synced = 0
        self._lost = 0
        self._dropped_by_daemon: int | None = None

    def write(self, packets: Iterable[bytes]) -> None:
        """Write packets' messages, or count them once the disk has refused."""
        for packet in packets:
            for parcel in wire.unpack(packet):
                self._file(parcel)

    def sync(self) -> None:
        """Put what was written on the disk."""
        if not self.failed:
            try:
                self._writer.sync()
                self._synced = self._writer.written
            except VsensorError as error:
                self._complain(error)

    def close(self, backlog: Backlog, *, told_to_end: bool) -> None:
        """Complete the session with the record of its own making."""
        if self.failed:
            _say(f"{self._writer.part}: up to {self._lost} messages are lost")
            return
        daemon = self._dropped_by_daemon
        ended = "the recorder was told to end" if told_to_end else "the daemon ended without closing it"
        try:
            self._writer.note(
                RECORDER,
                {
                    "written": str(self._writer.written),
                    "dropped_by_daemon": "unknown" if daemon is None else str(daemon),
                    "dropped_by_recorder": str(backlog.dropped),
                    "ended": ended if daemon is None else "closed by the daemon",
                },
            )
            self._writer.close()
        except VsensorError as error:
            self._complain(error)

    def _file(self, parcel: wire.Parcel) -> None:
        if parcel.topic == wire.FAREWELL:
            (self._dropped_by_daemon,) = wire.COUNT.unpack(parcel.data)
        elif self.failed:
            self._lost += 1
        else:
            try:
                self._writer.write(
                    parcel.topic.decode(), parcel.data, parcel.log_time_ns, parcel.publish_time_ns
                )
            except VsensorError as error:
                self._lost += 1
                self._complain(error)

    def _complain(self, error: VsensorError) -> None:
        self.failed = True
        self._lost += self._writer.written - self._synced
        _say(str(error))
        _tell(self._socket, str(error))


def main(descriptor: int, processors: Collection[int]) -> int:
    """Record until the daemon ends; 0 where the session was completed, 1 where it could not be."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _step_back(processors)
    feed = socket.socket(fileno=descriptor)
    order = json.load(sys.stdin)
    try:
        writer = SessionWriter(Path(order.pop("path")), **order)
    except VsensorError as error:
        _tell(feed, str(error))
        return 1
    told: list[int] = []
    backlog = Backlog(BACKLOG_BYTES)
    thread = threading.Thread(target=_receive, args=(feed, backlog), daemon=True)

    def end(number: int, _frame: object) -> None:
        told.append(number)
        with contextlib.suppress(OSError):  # what is in the buffer is still read, what comes after is refused
            feed.shutdown(socket.SHUT_RD)

    signal.signal(signal.SIGTERM, end)
    thread.start()
    _tell(feed, wire.READY)
    clerk = Clerk(writer, feed)
    _record(backlog, clerk)
    clerk.close(backlog, told_to_end=bool(told))
    return 1 if clerk.failed else 0


def _record(backlog: Backlog, clerk: Clerk) -> None:
    next_sync = time.monotonic() + SYNC_S
    warned = False
    while True:
        last = backlog.ended.wait(_LOOK_S)  # asked before taking: nothing comes after the end
        clerk.write(backlog.take())
        if backlog.dropped and not warned:
            warned = True
            _say(f"the disk does not keep up: {BACKLOG_BYTES >> 20} MiB wait for it, the rest is dropped")
        if last:
            return
        if time.monotonic() >= next_sync:
            clerk.sync()
            next_sync = time.monotonic() + SYNC_S


def _receive(feed: socket.socket, backlog: Backlog) -> None:
    try:
        while packet := _packet(feed):
            backlog.put(packet)
    finally:
        backlog.ended.set()


def _packet(feed: socket.socket) -> bytes:
    try:
        return feed.recv(wire.PACKET_BYTES)
    except ConnectionResetError:  # the daemon died with our words unread; told once, its last words follow
        return feed.recv(wire.PACKET_BYTES)


def _tell(feed: socket.socket, text: str) -> None:
    with contextlib.suppress(OSError):  # the daemon is gone
        feed.send(text.encode(), socket.MSG_DONTWAIT)


def _say(text: str) -> None:
    with contextlib.suppress(OSError):  # a closed terminal must not end the recording
        sys.stderr.write(f"vsensor recorder: {text}\n")
        sys.stderr.flush()


def _step_back(processors: Collection[int]) -> None:
    """Give up what the loop's thread handed down: its processor and priority are not for writing files."""
    if processors:
        with contextlib.suppress(OSError):
            os.sched_setaffinity(0, processors)
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), [int(number) for number in sys.argv[2].split(",") if number]))
