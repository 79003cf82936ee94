"""What the driller may tell the sensor while it runs, in plain words.

Each command that was obeyed is recorded among the samples, as an event whose text it is.
"""

import contextlib
import math
from fractions import Fraction

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
    plain = _about_bit(words)
    if plain in _BIT:
        depths.command(_BIT[plain])
        return f"the bit is held to be {plain}" if _BIT[plain] is not None else "the depths decide"
    depths.lengthen(_longer_by(words))
    return f"the string is now {depths.length:.1f} m long"


class Undo:
    """Commands that were obeyed, and what takes them back: so a record that holds them can begin anew."""

    def __init__(self) -> None:
        self._longer = Fraction(0)
        self._step = 0.0
        """The most that one command changed the length by: more at a time may be refused."""
        self._about_bit = False

    def note(self, words: str) -> None:
        """Hear of a command that was obeyed; of one about something else than the string, nothing is kept."""
        if _about_bit(words) in _BIT:
            self._about_bit = True
            return
        with contextlib.suppress(ValueError):
            metres = _longer_by(words)
            self._longer += Fraction(metres)
            self._step = max(self._step, abs(metres))

    def words(self) -> list[str]:
        """What to tell the sensor to have it as before, and forget them. The bit is left to the depths."""
        verb, left = "shorter" if self._longer > 0 else "longer", abs(self._longer)
        back = []
        while metres := min(float(left), self._step):
            back.append(f"{verb} {metres!r} m")
            left -= Fraction(metres) if metres == self._step else left
        if self._about_bit:
            back.append("by depths")
        self._longer, self._step, self._about_bit = Fraction(0), 0.0, False
        return back


def _about_bit(words: str) -> str:
    return " ".join(words.lower().replace("-", " ").split())


def _longer_by(words: str) -> float:
    """By how many metres the string becomes longer; ValueError where that is not what the words are about."""
    verb, _, length = words.strip().partition(" ")
    if verb.lower() not in _SIGN or not length.strip():
        raise ValueError(f"{words!r} is no command: {HELP}")
    metres = to_si(length.strip(), "m")
    if metres <= 0:
        raise ValueError(f"{length.strip()!r} is no length: {HELP}")
    return _SIGN[verb.lower()] * metres
