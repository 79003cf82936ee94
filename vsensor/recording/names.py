"""What sessions are called: RIG-20260131T235959Z.mcap, by the time at which they begin, in UTC."""

import re
import time
from pathlib import Path

_STAMP = "%Y%m%dT%H%M%SZ"


def session_path(folder: Path, rig: str, kind: str = "") -> Path:
    """A name that nobody has yet; `kind` is a word behind the time, such as -snapshot."""
    stem = f"{rig}-{time.strftime(_STAMP, time.gmtime())}{kind}"
    path = folder / f"{stem}.mcap"
    number = 2
    while path.exists() or path.with_name(f"{path.name}.part").exists():
        path = folder / f"{stem}-{number}.mcap"
        number += 1
    return path


def is_session_of(rig: str, name: str, ending: str = ".mcap") -> bool:
    """Whether a file's name is one that we give to a session of this rig; a snapshot's is not."""
    return bool(re.fullmatch(rf"{re.escape(rig)}-\d{{8}}T\d{{6}}Z(-\d+)?{re.escape(ending)}", name))
