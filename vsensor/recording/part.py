"""One file under way: what goes into it, and what it says of itself at its end."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vsensor.messages import SENSOR_STATE
from vsensor.recording import wire
from vsensor.recording.writer import RECORDER, Compression, GoneError, SessionWriter


class Head(NamedTuple):
    """What every file of a recording has at its start."""

    configuration: str
    metadata: Mapping[str, str]
    compression: Compression

    def writer(self, path: Path, more: Mapping[str, str]) -> SessionWriter:
        """Begin a file, with something more to say of it."""
        return SessionWriter(
            path,
            configuration=self.configuration,
            metadata={**self.metadata, **more},
            compression=self.compression,
        )


def write_state(writer: SessionWriter, checkpoint: wire.Checkpoint) -> None:
    """Write what the sensor remembers at this place."""
    state = wire.state_of(checkpoint.remembered)
    data = state.SerializeToString()
    writer.write(SENSOR_STATE, data, checkpoint.time_ns, state.time_ns or checkpoint.time_ns)


class Losses(NamedTuple):
    """Messages lost since the start: by the daemon, as far as it has told (None: it has not), and by us."""

    daemon: int | None
    recorder: int


class Part:
    """A file that is being written. All raise VsensorError where the disk refuses."""

    def __init__(self, path: Path, head: Head, more: Mapping[str, str], before: Losses) -> None:
        self.path = path
        self.begun = time.monotonic()
        self.unsynced = 0
        """Messages that a power cut would take."""
        self._before = before
        self._writer = head.writer(path, more)

    @property
    def unfinished(self) -> Path:
        """Where it stands until it is complete."""
        return self._writer.part

    @property
    def empty(self) -> bool:
        """Whether no message is in it yet."""
        return not self._writer.written

    @property
    def size(self) -> int:
        """Bytes on the disk."""
        return self._writer.size

    def write(self, parcel: wire.Parcel) -> None:
        """Write a message."""
        self.unsynced += 1
        self._writer.write(parcel.topic.decode(), parcel.data, parcel.log_time_ns, parcel.publish_time_ns)

    def remember(self, checkpoint: wire.Checkpoint) -> None:
        """Write what the sensor remembers at this place."""
        self.unsynced += 1
        write_state(self._writer, checkpoint)

    def sync(self) -> None:
        """Put what was written on the disk."""
        self._writer.sync()
        self.unsynced = 0

    def lost(self, error: Exception) -> int:
        """How many of its messages an error of ours has cost."""
        return self._writer.written if isinstance(error, GoneError) else self.unsynced

    def close(self, why: str, losses: Losses) -> None:
        """Complete it with the record of its own making."""
        known = losses.daemon is not None
        by_daemon = str((losses.daemon or 0) - (self._before.daemon or 0)) if known else "unknown"
        self._writer.note(
            RECORDER,
            {
                "written": str(self._writer.written),
                "dropped_by_daemon": by_daemon,
                "dropped_by_recorder": str(losses.recorder - self._before.recorder),
                "ended": why,
            },
        )
        self._writer.close()
