"""What was learned, kept on the disk from one start to the next: whole, or as it was before.

Written by a thread of its own, since a disk may take seconds; the loop never waits for it.
"""

import os
import queue
import threading
import time
from pathlib import Path
from typing import NamedTuple

from google.protobuf.message import DecodeError

from vsensor.config import Rig
from vsensor.learned import begin_with, learned
from vsensor.messages import Learned
from vsensor.service.engine import Engine

EVERY_S = 30.0
"""How often it is saved; a string that has become longer is saved at once."""
END_S = 5.0
"""How long the last saving may take."""
MOST_BYTES = 10_000_000
"""What is learned takes some kilobytes."""


def path_of(rig: Rig) -> Path:
    """The file of one rig's sensor."""
    return rig.state.folder / f"{rig.rig.name}.learned"


class Begun(NamedTuple):
    """What was done with what the file held at the start: words, none where there was none."""

    words: str = ""
    refused: bool = False


def take_up(path: Path, rig: Rig, engine: Engine) -> Begun:
    """Begin with what the file holds; returns what was done.

    A file that does not fit is put aside under another name, and the words say why.
    """
    try:
        if path.stat().st_size > MOST_BYTES:
            raise ValueError(f"it is larger than {MOST_BYTES} bytes")
        before = Learned.FromString(path.read_bytes())
        begin_with(before, rig, engine.intake, engine.estimator)
    except FileNotFoundError:
        return Begun()
    except (OSError, ValueError, DecodeError) as error:
        return Begun(f"what was learned before is refused{_put_aside(path)}: {error}", refused=True)
    when = time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(before.saved_ns / 1e9))
    return Begun(f"goes on with what was learned until {when}, a string of {before.string_length_m:.1f} m")


def _put_aside(path: Path) -> str:
    aside = path.with_suffix(".refused")
    try:
        path.replace(aside)
    except OSError:
        return ""
    return f" and put aside as {aside}"


class Keeper:
    """Begins with what one sensor had learned, and saves what it learns. It never waits but in `close`."""

    def __init__(self, path: Path, rig: Rig, engine: Engine) -> None:
        self.begun = take_up(path, rig, engine)
        self.trouble = ""
        """Why it could not be saved the last time."""
        self.saved_ns = 0
        """When it was, by our clock."""
        self._path = path
        self._rig = rig
        self._engine = engine
        self._length = engine.intake.depths.length
        self._due_s = time.monotonic() + EVERY_S
        self._orders: queue.SimpleQueue[Learned | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name="keeper", daemon=True)
        self._thread.start()

    def each_second(self) -> None:
        """Have it saved, where that is due and the last saving is done."""
        longer = self._engine.intake.depths.length != self._length
        if (longer or time.monotonic() >= self._due_s) and self._orders.empty():
            self.save()

    def close(self) -> None:
        """Wait for the last saving."""
        self._orders.put(None)
        self._thread.join(END_S)

    def save(self) -> None:
        """Have it saved now."""
        self._length = self._engine.intake.depths.length
        self._due_s = time.monotonic() + EVERY_S
        self._orders.put(learned(self._rig, self._engine.intake, self._engine.estimator))

    def _work(self) -> None:
        while (order := self._orders.get()) is not None:
            try:
                write_whole(self._path, order.SerializeToString())
                self.saved_ns, self.trouble = order.saved_ns, ""
            except OSError as error:
                self.trouble = f"{self._path}: cannot be written: {error.strerror or error}"


def write_whole(path: Path, data: bytes) -> None:
    """Write a file that is there as a whole, or as it was before, whenever power fails. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{path.name}.part")
    with part.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
