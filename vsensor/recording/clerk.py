"""Decides what is written where: begins, splits and ends files, and says what became of them."""

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vsensor.errors import VsensorError
from vsensor.recording import wire
from vsensor.recording.backlog import Backlog, Item
from vsensor.recording.disk import Disk
from vsensor.recording.limits import Limits
from vsensor.recording.mend import Mender
from vsensor.recording.names import session_path, untaken
from vsensor.recording.part import Head, Losses, Part
from vsensor.recording.snapshot import Snapshots
from vsensor.recording.writer import GoneError

RETRY_S = 10.0
"""A disk that has refused is not tried again sooner."""

EVENTS, TEXT, FILES = 10, 500, 4
"""So many events, of so many characters, and so many names of files fit into a packet of news."""

News = dict[str, Any]


class Clerk:
    """Writes the daemon's messages into sessions, and has news of it.

    A file begins with what the sensor remembers at that moment, so that each can be run again on its own;
    where the clerk wants that, its news say so. Raises nothing once begun: what goes wrong is news. `backlog`
    is where the messages wait before they are taken in.
    """

    def __init__(
        self,
        path: Path,
        head: Head,
        limits: Limits,
        backlog: Backlog | None = None,
        disk: Disk | None = None,
    ) -> None:
        self.failed = False
        """Whether the last file could not be completed."""
        self._folder = path.parent
        self._rig = head.metadata.get("rig", "")
        self._head = head
        self._limits = limits
        self._backlog = backlog or Backlog(0)
        self._disk = disk or Disk(self._folder, self._rig, limits)
        self._mender = Mender(self._folder, self._rig)
        self._snapshots = Snapshots(head, limits.memory)
        self._part: Part | None = None
        self._parts = 0
        self._wanted = False
        self._trouble = ""
        self._not_before = 0.0
        self._lost = 0
        self._lost_by_daemon = 0
        self._known = self._losses()
        """Losses at which the present file tells last what the sensor remembered."""
        self._farewell = False
        self._state = 0
        self._orders = 0
        self._events: list[tuple[str, bool, str]] = []
        self._complete: list[str] = []

    def begin(self, path: Path) -> None:
        """Begin the first file before anything came. Raises VsensorError where it cannot be created."""
        self._wanted = True
        self._tidy(now=True)
        if not self._disk.has_room():
            self._trouble = f"{self._folder}: {self._too_full()}"
            return
        # A machine without a clock of its own begins twice in the same second.
        self._part = Part(untaken(path), self._head, {"part": "1"}, self._losses())
        self._parts = 1
        self.note("recording", True, f"recording into {self._part.path}")
        self.mend()

    def mend(self) -> None:
        """Mend what a crash before has torn, out of the way."""
        self._mender.start(self._disk.spare)

    def take(self, item: Item) -> None:
        """Take what came: messages, orders, what the sensor remembers."""
        if isinstance(item, wire.Heading):
            self._head = self._snapshots.head = self._head._replace(**item._asdict())
            return
        if isinstance(item, wire.Checkpoint):
            self._snapshots.memory.begin(item, time.monotonic())
            self._state = item.order["state"]
            self._hear_of_losses(item.order)
            self._go_on(item)
            return
        self._snapshots.memory.add(item)
        for parcel in wire.unpack(item):
            if parcel.topic:
                self._file(parcel)
            else:
                self._obey(wire.order_of(parcel))

    def work(self) -> None:
        """Write a piece of the snapshot that is under way."""
        if wrong := self._snapshots.work():
            self.note("snapshot", False, wrong)
        for path in self._snapshots.complete:
            self._complete.append(str(path))
            self.note("snapshot", True, f"{path} is kept")
        self._snapshots.complete.clear()

    def each_second(self) -> None:
        """Put what was written on the disk, and look after the disk."""
        if self._part is not None:
            with self._complaining():
                self._part.sync()
        self._tidy(now=False)
        self._guard()
        for line in self._mender.finished():
            self.note("session_mended", True, line)

    def close(self, *, told_to_end: bool) -> None:
        """Complete what is under way."""
        while self._snapshots.busy:
            self.work()
        if self._part is None:
            return
        if self._farewell:
            self._end("closed by the daemon")
            return
        why = "the recorder was told to end" if told_to_end else "the daemon ended without closing it"
        self._end(why, Losses(None, self._losses().recorder))

    def note(self, name: str, begins: bool, text: str) -> None:
        """Something that has happened, for the next news."""
        self._events.append((name, begins, text))

    def news(self) -> News:
        """How things stand, and what has happened since the last news; figures named as in the status."""
        part = self._part
        news: News = {
            "path": "" if part is None else str(part.path),
            "state": self._state,
            "orders": self._orders,
            "lost": self._lost + self._backlog.dropped,
            "trouble": self._trouble,
            "wanted": self._wanted,
            "wants": self._is_due(part) or self._has_gap if part else self._wanted and self._may_begin(),
            "events": [(name, begins, text[:TEXT]) for name, begins, text in self._events[:EVENTS]],
            "complete": self._complete[:FILES],
            "figures": {
                "recording_bytes": part.size if part else 0,
                "recording_free_bytes": self._disk.free,
                "recording_parts": self._parts,
                "recording_deleted": self._disk.deleted,
                "recording_backlog_bytes": self._backlog.most,
                "recording_memory_s": self._snapshots.memory.reach(time.monotonic()),
            },
        }
        del self._events[:EVENTS], self._complete[:FILES]
        return news

    @property
    def has_more(self) -> bool:
        """Whether there is news that the last could not hold."""
        return bool(self._events or self._complete)

    def _file(self, parcel: wire.Parcel) -> None:
        if self._part is not None:
            with self._complaining():
                self._part.write(parcel)
        elif self._wanted:
            self._lost += 1

    def _obey(self, order: dict[str, Any]) -> None:
        self._hear_of_losses(order)
        match order["order"]:
            case wire.FAREWELL:
                self._farewell = True
            case wire.STOP:
                if self._part is not None:
                    self._end("stopped on command")
                self._wanted, self._trouble = False, ""
            case wire.SNAPSHOT:
                path = untaken(Path(order["path"]))
                if wrong := self._snapshots.begin(path, order["seconds"], self._disk.spare):
                    self.note("snapshot", False, wrong)

    def _go_on(self, checkpoint: wire.Checkpoint) -> None:
        """With what the sensor remembers: begin a file, split one, or note it in the present one."""
        order = checkpoint.order["order"]
        self._wanted = self._wanted or order == wire.START
        path = Path(checkpoint.order["path"]) if checkpoint.order["path"] else None
        part = self._part
        if part is None:
            if self._wanted and self._may_begin():
                self._open(path, checkpoint, "")
        elif not part.empty and (order == wire.SPLIT or self._is_due(part)):
            self._end("continued in the next part")
            self._open(path, checkpoint, part.path.name)
        elif part.empty or self._has_gap:
            self._remember(part, checkpoint)

    def _remember(self, part: Part, checkpoint: wire.Checkpoint) -> None:
        with self._complaining():
            part.remember(checkpoint)
            self._known = self._losses()

    @property
    def _has_gap(self) -> bool:
        """Whether something was lost since: what follows can only be run again from a new state."""
        return self._losses() != self._known

    def _hear_of_losses(self, order: dict[str, Any]) -> None:
        self._lost_by_daemon = order["dropped"]
        self._orders = order.get("orders", self._orders)

    def _open(self, path: Path | None, checkpoint: wire.Checkpoint, continues: str) -> None:
        path = untaken(path or session_path(self._folder, self._rig))
        was_torn, self.failed = self.failed, False
        more = {"part": str(self._parts + 1)} | ({"continues": continues} if continues else {})
        self._tidy(now=True)
        with self._complaining():
            self._part = Part(path, self._head, more, self._losses())
            self._parts += 1
            self._trouble = ""
            self._remember(self._part, checkpoint)
            self.note("recording", True, f"recording into {path}")
        if was_torn and not self.failed:
            self.mend()

    def _end(self, why: str, losses: Losses | None = None) -> None:
        part, self._part = self._part, None
        if part is None:
            return
        try:
            part.close(why, losses or self._losses())
        except VsensorError as error:
            self._fail(part, error)
            return
        self.failed = False
        self._complete.append(str(part.path))
        self.note("recording", False, f"{part.path} is complete: {why}")

    @contextlib.contextmanager
    def _complaining(self) -> Iterator[None]:
        try:
            yield
        except VsensorError as error:
            self._fail(self._part, error)

    def _fail(self, part: Part | None, error: VsensorError) -> None:
        self._part = None
        self.failed = True
        self._lost += part.lost(error) if part is not None else 0
        self._trouble = str(error)
        if not isinstance(error, GoneError):  # which is no word of the disk's
            self._not_before = time.monotonic() + RETRY_S
        self.note("recording", False, str(error))

    def _guard(self) -> None:
        """End while there is still room to end in."""
        if self._part is None or self._disk.has_room():
            return
        why = self._too_full()
        self._end(why)
        self._trouble = self._trouble or f"{self._folder}: {why}"

    def _too_full(self) -> str:
        return f"the disk has only {_size(self._disk.free)} left, {_size(self._limits.keep_free)} must stay"

    def _is_due(self, part: Part) -> bool:
        limits = self._limits
        too_long = limits.split_every and time.monotonic() - part.begun >= limits.split_every
        return bool(too_long or (limits.split_size and part.size >= limits.split_size))

    def _may_begin(self) -> bool:
        return time.monotonic() >= self._not_before and self._disk.has_room(to_begin=True)

    def _tidy(self, *, now: bool) -> None:
        for path in self._disk.tidy(now=now):
            self.note("session_deleted", True, f"{path} was deleted to keep within the limits")

    def _losses(self) -> Losses:
        return Losses(self._lost_by_daemon, self._lost + self._backlog.dropped)


def _size(count: float) -> str:
    return f"{count / 1e9:.3g} GB" if count >= 1e9 else f"{count / 1e6:.3g} MB"
