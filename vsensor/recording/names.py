"""What sessions are called: RIG-20260131T235959Z.mcap, by the time at which they begin, in UTC."""

import re
import time
from pathlib import Path

_STAMP = "%Y%m%dT%H%M%SZ"


def session_path(folder: Path, rig: str, kind: str = "") -> Path:
    """The name of what begins now; `kind` is a word behind the time, such as -snapshot."""
    return folder / f"{rig}-{time.strftime(_STAMP, time.gmtime())}{kind}.mcap"


def untaken(path: Path) -> Path:
    """This name, or where somebody has it, the next that is free."""
    free, number = path, 2
    while free.exists() or free.with_name(f"{free.name}.part").exists():
        free = path.with_stem(f"{path.stem}-{number}")
        number += 1
    return free


def is_session_of(rig: str, name: str, ending: str = ".mcap") -> bool:
    """Whether a file's name is one that we give to a session of this rig; a snapshot's is not."""
    return bool(re.fullmatch(rf"{re.escape(rig)}-\d{{8}}T\d{{6}}Z(-\d+)?{re.escape(ending)}", name))


def recovering(path: Path) -> Path:
    """Where a session is written while it is mended: NAME.mcap.part may be the torn one itself."""
    return path.with_name(f"{path.name}.recovering")
