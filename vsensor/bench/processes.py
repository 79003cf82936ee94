"""What Linux says of our processes: their children, and the processor time they took."""

import os
from pathlib import Path

from vsensor.errors import VsensorError

_PROC = Path("/proc")
_PARENT, _USER, _SYSTEM = 1, 11, 12
"""Fields of /proc/PID/stat behind the command's name (proc(5): 4, 14 and 15)."""


def child_of(pid: int) -> int:
    """The one child of a process. Raises VsensorError where it has none or several."""
    children = [
        int(folder.name)
        for folder in _PROC.iterdir()
        if folder.name.isdecimal() and (fields := _stat(folder)) and int(fields[_PARENT]) == pid
    ]
    if len(children) != 1:
        raise VsensorError(
            f"process {pid} has {len(children)} children, where the recorder alone was expected"
        )
    return children[0]


def processor_s(pid: int) -> float:
    """Processor time that a process has taken since its start, s; 0 where it has gone."""
    fields = _stat(_PROC / str(pid))
    return (int(fields[_USER]) + int(fields[_SYSTEM])) / os.sysconf("SC_CLK_TCK") if fields else 0.0


def resident_bytes(pid: int) -> int:
    """Memory that a process holds; 0 where it has gone."""
    try:
        pages = int((_PROC / str(pid) / "statm").read_text().split()[1])
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")


def _stat(folder: Path) -> list[str]:
    try:
        return (folder / "stat").read_text().rpartition(")")[2].split()
    except OSError:  # it has ended meanwhile
        return []
