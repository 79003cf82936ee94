"""What the driller may tell the sensor while it runs, in plain words.

Each command that was obeyed is recorded among the samples, as an event whose text it is.
"""

import math

from vsensor.depth import Depths
from vsensor.units import to_si

COMMAND = "command"
"""The name of such an event."""
HELP = (
    'say "off bottom", "on bottom", "by depths", "longer 28.5 m" or "shorter 28.5 m"; '
    '"start recording", "stop recording", "split recording" or "snapshot 5 min"'
)
"""What would be right."""

_BIT = {"off bottom": True, "on bottom": False, "by depths": None}
_SIGN = {"longer": 1.0, "shorter": -1.0}


RECORDING = ("start", "stop", "split")
SNAPSHOT = "snapshot"


def about_recording(words: str) -> tuple[str, float] | None:
    """Read what the recorder is told: start, stop, split, or snapshot and of how many seconds.

    None where it is told nothing; infinite where all that is held is wanted. Raises ValueError where a
    snapshot is asked of no length of time.
    """
    verb, _, rest = " ".join(words.lower().split()).partition(" ")
    if verb in RECORDING and rest == "recording":
        return verb, 0.0
    if verb != SNAPSHOT:
        return None
    seconds = to_si(rest, "s") if rest else math.inf
    if seconds <= 0:
        raise ValueError(f"{rest!r} is no length of time: {HELP}")
    return SNAPSHOT, seconds


def obey(words: str, depths: Depths) -> str:
    """Do what was told; returns what was done. Raises ValueError with what would have been right."""
    plain = " ".join(words.lower().replace("-", " ").split())
    if plain in _BIT:
        depths.command(_BIT[plain])
        return f"the bit is held to be {plain}" if _BIT[plain] is not None else "the depths decide"
    verb, _, length = words.strip().partition(" ")
    if verb.lower() not in _SIGN or not length.strip():
        raise ValueError(f"{words!r} is no command: {HELP}")
    metres = to_si(length.strip(), "m")
    if metres <= 0:
        raise ValueError(f"{length.strip()!r} is no length: {HELP}")
    if not depths.lengthen(_SIGN[verb.lower()] * metres):
        raise ValueError(f"the string is {depths.length:.1f} m long: no pipe would be left of it")
    return f"the string is now {depths.length:.1f} m long"
