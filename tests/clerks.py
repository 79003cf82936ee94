"""A clerk of the recording, and what a daemon would hand to it; what it has left in its folder."""

import os
import time
from pathlib import Path
from typing import Any

from vsensor.messages import SENSOR_STATE, SURFACE_TORQUE, Sample, State
from vsensor.recording import wire
from vsensor.recording.clerk import Clerk, News
from vsensor.recording.disk import Disk
from vsensor.recording.limits import Limits
from vsensor.recording.part import Head
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

RIG = "r"
HEAD = Head("[rig]", {"rig": RIG}, "zstd")
NAME = f"{RIG}-20260101T000000Z.mcap"


class Desk:
    """A clerk, and what a daemon would hand to it."""

    def __init__(self, folder: Path, limits: Limits, begin: bool = True) -> None:
        self.folder = folder
        self.free = 1 << 40
        self.sent = 0
        self.news: list[News] = []
        disk = Disk(folder, RIG, limits, lambda _: self.free)
        self.clerk = Clerk(folder / NAME, HEAD, limits, disk=disk)
        if begin:
            self.clerk.begin(folder / NAME)

    def send(self, count: int) -> None:
        for _ in range(count):
            data = Sample(sequence=self.sent, value=self.sent).SerializeToString()
            topic = SURFACE_TORQUE.encode()
            head = wire.HEAD.pack(len(topic), len(data), self.sent, self.sent)
            self.clerk.take(head + topic + data)
            self.sent += 1

    def remember(self, order: str = wire.KEEP, path: Path | None = None, dropped: int = 0) -> None:
        """Hand over a state; its number is that of the next message."""
        header = State(number=self.sent).SerializeToString()
        words = {"order": order, "path": "" if path is None else str(path), "dropped": dropped, "state": 0}
        remembered = len(header).to_bytes(4, "little") + header
        self.clerk.take(wire.Checkpoint(words, time.time_ns(), remembered))

    def order(self, **words: Any) -> None:
        self.clerk.take(wire.packed_order({"dropped": 0, "path": "", "seconds": 0.0, **words}, 0))

    def look(self) -> News:
        self.clerk.each_second()
        self.clerk.work()
        self.news.append(self.clerk.news())
        return self.news[-1]

    def close(self) -> None:
        self.order(order=wire.FAREWELL)
        self.clerk.close(told_to_end=False)
        self.news.append(self.clerk.news())

    def failed(self) -> bool:
        return self.clerk.failed

    @property
    def events(self) -> list[tuple[str, bool]]:
        return [(name, begins) for news in self.news for name, begins, _ in news["events"]]


def numbers(path: Path) -> list[int]:
    """Of the samples in a session."""
    return [r.message.sequence for r in Session(path).messages((SURFACE_TORQUE,))]  # type: ignore[union-attr]


def states(path: Path) -> list[tuple[int, int]]:
    """Each state in a session: behind how many samples it stands, and the number that it tells."""
    found, samples = [], 0
    for topic, message, _, _ in Session(path).messages():
        if topic == SENSOR_STATE and isinstance(message, State):
            found.append((samples, message.number))
        samples += topic == SURFACE_TORQUE
    return found


def sessions(folder: Path) -> list[Path]:
    """Complete ones, in the order of their making."""
    return sorted(folder.glob("*.mcap"), key=lambda path: path.stat().st_mtime_ns)


def made(path: Path, rig: str = RIG, age_s: float = 0.0, complete: bool = True, size: int = 0) -> Path:
    """A session of some age, filled up to some size."""
    with SessionWriter(path, configuration=" " * size, metadata={"rig": rig}, compression="none") as writer:
        writer.write(SURFACE_TORQUE, b"", 1, 1)
    if not complete:
        path.write_bytes(path.read_bytes()[:-20])
    os.utime(path, (time.time() - age_s,) * 2)
    return path


def at(hour: int, rig: str = RIG, more: str = "") -> str:
    return f"{rig}-20260101T{hour:02d}0000Z{more}.mcap"
