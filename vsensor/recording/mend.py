"""Sessions that a crash or a power cut has torn, mended when the recorder starts next.

Started by the recorder's process as `python -m vsensor.recording.mend FOLDER RIG`, out of its way. What is
mended becomes NAME.mcap, and the torn one is kept as NAME.mcap.torn. Where mending was interrupted itself, it
is done again.
"""

import contextlib
import fcntl
import os
import subprocess
import sys
from pathlib import Path

from vsensor.errors import VsensorError
from vsensor.recording.names import is_session_of, recovering, untaken
from vsensor.recording.reader import Session
from vsensor.recording.writer import RECOVERED_FROM


def torn(folder: Path, rig: str) -> list[Path]:
    """The unfinished sessions of this rig that nobody is writing, or mending."""
    parts = (p for p in sorted(folder.glob(f"{rig}-*.mcap.part")) if is_session_of(rig, p.name, ".mcap.part"))
    return [part for part in parts if not (_is_held(part) or _is_held(recovering(part.with_suffix(""))))]


def mend(part: Path) -> str:
    """Mend one; returns what became of it, in words."""
    from vsensor.recording.recover import recover  # with Numba, which the recorder's process does not load
    from vsensor.recording.survey import NothingLeftError

    path, kept = part.with_suffix(""), part.with_suffix(".torn")
    if _comes_of(path, part):
        part.rename(kept)
        return f"{path} was torn and is mended; the torn one is kept as {kept.name}"
    try:
        Session(part)
    except VsensorError as error:
        part.rename(kept)
        return f"{error}: nothing of it could be saved, it is kept as {kept.name}"
    output = untaken(path) if path.exists() else path
    recovering(output).unlink(missing_ok=True)
    try:
        recovered = recover(part, output)
    except NothingLeftError as error:
        part.rename(kept)
        return f"{error}; it is kept as {kept.name}"
    except VsensorError as error:
        recovering(output).unlink(missing_ok=True)  # its room is wanted
        return f"{part} is torn and could not be mended, which is tried again at the next start: {error}"
    part.rename(kept)
    return (
        f"{recovered.path} was torn and is mended: {recovered.messages} messages; "
        f"{recovered.lost or 'nothing'} could not be read; the torn one is kept as {kept.name}"
    )


def _comes_of(path: Path, part: Path) -> bool:
    """Whether a session is what mending has made of a torn one already."""
    try:
        session = Session(path)
    except VsensorError:
        return False
    return session.complete and session.metadata.get(RECOVERED_FROM) == part.name


def _is_held(part: Path) -> bool:
    """Whether a writer has it open: each locks its file."""
    if not part.exists():
        return False
    try:
        with part.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:  # held, or a file system that knows no locks: better left alone
        return True
    return False


class Mender:
    """The mending as a process of its own, at the lowest priority."""

    def __init__(self, folder: Path, rig: str) -> None:
        self._folder = folder
        self._rig = rig
        self._process: subprocess.Popen[str] | None = None

    def start(self, spare: float) -> None:
        """Begin, where something is torn and so many bytes of disk have room for it."""
        parts = torn(self._folder, self._rig)
        if not parts or sum(part.stat().st_size for part in parts) > spare:
            return
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "vsensor.recording.mend", str(self._folder), self._rig],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
        )

    def finished(self) -> list[str]:
        """What became of each, once all is done; never waits."""
        if self._process is None or self._process.poll() is None:
            return []
        with self._process as process:
            self._process = None
            return process.stdout.read().splitlines() if process.stdout else []


def main(folder: Path, rig: str) -> None:
    """Mend what is torn, a line on standard output for each."""
    with contextlib.suppress(OSError):
        os.nice(19)
    for part in torn(folder, rig):
        with contextlib.suppress(OSError):  # taken away meanwhile
            sys.stdout.write(f"{mend(part)}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
