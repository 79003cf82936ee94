"""The newest minutes written into a file of their own, a piece at a time."""

import time
from collections.abc import Iterator
from pathlib import Path

from vsensor.errors import VsensorError
from vsensor.recording import wire
from vsensor.recording.memory import Memory, Segment
from vsensor.recording.part import Head, write_state
from vsensor.recording.writer import SessionWriter

SLICE_S = 0.03
"""A snapshot is written in pieces of this, so that what comes meanwhile is not kept waiting."""


class Snapshots:
    """The memory, and the one snapshot that may be under way."""

    def __init__(self, head: Head, seconds: float) -> None:
        self.memory = Memory(seconds)
        self.complete: list[Path] = []
        """Those that were written, until somebody takes them from here."""
        self.head = head
        """What the next begins with."""
        self._path = Path()
        self._steps: Iterator[None] | None = None

    def begin(self, path: Path, seconds: float, spare: float) -> str:
        """Begin to write the last `seconds`; returns what keeps it from that, if anything does."""
        now = time.monotonic()
        segments = self.memory.newest(seconds, now)
        if self._steps is not None:
            return f"{path} is not kept: another is still being written"
        if not segments:
            return f"{path} is not kept: nothing is held in memory yet"
        if self.memory.size > spare:
            return f"{path} is not kept: the disk is too full"
        try:
            writer = self.head.writer(path, {"snapshot_s": f"{now - segments[0].begun:.3f}"})
        except VsensorError as error:
            return str(error)
        self._path = path
        self._steps = _written(segments, writer)
        return ""

    def work(self) -> str:
        """Write a piece, where there is something to write; returns what went wrong, if anything did."""
        until = time.monotonic() + SLICE_S
        try:
            while self._steps is not None and time.monotonic() < until:
                next(self._steps)
        except StopIteration:
            self._steps = None
            self.complete.append(self._path)
        except VsensorError as error:
            self._steps = None
            return str(error)
        return ""

    @property
    def busy(self) -> bool:
        """Whether one is under way."""
        return self._steps is not None


def _written(segments: list[Segment], writer: SessionWriter) -> Iterator[None]:
    """Write segments, a packet at each step, and complete the file at the last."""
    write_state(writer, segments[0].checkpoint)
    for packet in (packet for segment in segments for packet in segment.packets):
        for parcel in wire.unpack(packet):
            if parcel.topic:
                writer.write(parcel.topic.decode(), parcel.data, parcel.log_time_ns, parcel.publish_time_ns)
        yield
    writer.close()
