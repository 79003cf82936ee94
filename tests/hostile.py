"""Reads files that somebody else has made, and tells what that took: run as a process, within bounds.

`python -m tests.hostile FOLDER` reads each file of the folder in every way that there is, and those named
*.cut at every length down to nothing. A line for each tells what came of it; the last, how much the memory
has grown.
"""

import contextlib
import os
import resource
import sys
from collections.abc import Callable
from pathlib import Path

from vsensor.errors import VsensorError
from vsensor.messages import SENSOR_TICK, SURFACE_TORQUE
from vsensor.recording.columns import read_columns
from vsensor.recording.course import Course
from vsensor.recording.reader import Session
from vsensor.recording.recover import recover

MEMORY_BYTES = 6 << 30
PROCESSOR_S = 60
MEND_EACH = 50
"""Of the lengths to which a file is cut only each of these is mended: that waits for the disk."""


def bound() -> None:
    """No harm to the machine, whatever is in the files."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    most = pages * os.sysconf("SC_PAGE_SIZE") + MEMORY_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_S, PROCESSOR_S))


def peak_bytes() -> int:
    """The most memory that the process has held so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss << 10


def read(path: Path, *, mending: bool = True) -> str:
    """Read a file in every way; what came of each: a number of messages, or a refusal that names the file."""
    mended = path.parent.with_suffix(".mcap")
    mended.unlink(missing_ok=True)
    ways: list[Callable[[], int]] = [
        lambda: Session(path).summary().messages,
        lambda: sum(1 for _ in Session(path).messages()),
        lambda: sum(1 for _ in Course([Session(path)]).between(0, float("inf"))),
        lambda: columns(path),
        lambda: recover(path, mended).messages,
    ]
    if not mending:
        ways.pop()
    return " ".join(outcome(way, path) for way in ways)


def columns(path: Path) -> int:
    """Messages read by columns."""
    wanted = {SURFACE_TORQUE: ("time_ns", "value"), SENSOR_TICK: ("number",)}
    return sum(len(found) for part in read_columns(Session(path), wanted) for found in part.values())


def outcome(way: Callable[[], int], path: Path) -> str:
    try:
        return str(way())
    except VsensorError as error:
        return "refused" if str(path) in str(error) else f"refused-without-a-name:{error}"


def main(folder: Path) -> None:
    """Read the folder's files."""
    paths = sorted(folder.iterdir())
    with contextlib.suppress(VsensorError):  # all code is loaded before memory is measured
        read(paths[0])
    bound()
    before = peak_bytes()
    for path in paths:
        if path.suffix == ".cut":
            for size in range(path.stat().st_size, -1, -1):
                os.truncate(path, size)
                print(path.name, size, read(path, mending=size % MEND_EACH == 0), flush=True)
        else:
            print(path.name, path.stat().st_size, read(path), flush=True)
    print("grown", peak_bytes() - before)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
