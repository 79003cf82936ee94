"""The disk that sessions are written on: what is free on it, and what is deleted to keep it so."""

import contextlib
import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path

from vsensor.errors import VsensorError
from vsensor.recording.limits import Limits
from vsensor.recording.names import is_session_of
from vsensor.recording.reader import Session

TIDY_S = 60.0
AGAIN = 1.1
"""So much more than the least must be free before writing begins again, or it would end at once."""


def room_on(folder: Path) -> int:
    """Free bytes on a folder's disk; the nearest folder above counts where it does not exist yet."""
    while not folder.exists():
        folder = folder.parent
    return shutil.disk_usage(folder).free


class Disk:
    """One rig's folder of sessions."""

    def __init__(self, folder: Path, rig: str, limits: Limits, room: Callable[[Path], int] = room_on) -> None:
        self.deleted = 0
        """Old sessions deleted so far."""
        self._folder = folder
        self._rig = rig
        self._limits = limits
        self._room = room
        self._next_tidy = 0.0

    @property
    def free(self) -> int:
        """Bytes."""
        try:
            return self._room(self._folder)
        except OSError:
            return 0

    @property
    def spare(self) -> float:
        """Bytes that may be written."""
        return self.free - self._limits.keep_free

    def has_room(self, *, to_begin: bool = False) -> bool:
        """Whether writing may go on, or begin."""
        least = self._limits.keep_free * (AGAIN if to_begin else 1.0)
        return not least or self.free >= least

    def tidy(self, *, now: bool) -> list[Path]:
        """Delete what the limits ask for, at once or where it is due; returns what was deleted."""
        if not now and time.monotonic() < self._next_tidy:
            return []
        self._next_tidy = time.monotonic() + TIDY_S
        deleted = tidy(self._folder, self._rig, self._limits)
        self.deleted += len(deleted)
        return deleted


def tidy(folder: Path, rig: str, limits: Limits) -> list[Path]:
    """Delete the sessions of this rig that are too old, and the oldest while all are too large; returns them.

    Only complete ones, which say themselves that they are of this rig, and torn ones that were mended, under
    the names that the recorder gives: never a snapshot, one that was renamed, or one that is being written.
    """
    if not (limits.keep_for or limits.keep_size):
        return []
    found = sorted(
        (status.st_mtime, status.st_size, path)
        for path in folder.glob(f"{rig}-*.mcap*")
        if (is_session_of(rig, path.name) or _is_torn(path, rig)) and (status := _status(path)) is not None
    )
    excess = sum(size for _, size, _ in found) - (limits.keep_size or float("inf"))
    oldest_kept = time.time() - (limits.keep_for or float("inf"))
    deleted = []
    for changed, size, path in found:
        if excess <= 0 and changed >= oldest_kept:
            break
        if _is_ours(path, rig):
            with contextlib.suppress(OSError):
                path.unlink()
                deleted.append(path)
                excess -= size
    return deleted


def _status(path: Path) -> os.stat_result | None:
    try:
        return path.stat()
    except OSError:  # gone meanwhile
        return None


def _is_torn(path: Path, rig: str) -> bool:
    """Whether it is what a session was mended from, which nobody but us names so."""
    return is_session_of(rig, path.name, ".mcap.torn")


def _is_ours(path: Path, rig: str) -> bool:
    if _is_torn(path, rig):
        return True
    try:
        session = Session(path)
    except VsensorError:
        return False
    return session.complete and session.metadata.get("rig") == rig
