"""A session's surface samples given out again at the pace at which they were taken."""

import math
from collections.abc import Callable
from enum import Enum
from typing import Protocol

from vsensor.messages import Sample
from vsensor.recording.laps import laps
from vsensor.recording.reader import Session

_LOOK_NS = 50_000_000  # how often a waiting player looks whether it is told anything


class Clock(Protocol):
    """What the player knows of time; a test brings its own."""

    def now_ns(self) -> int:
        """The present, on a clock that never jumps."""

    def sleep_until(self, time_ns: int) -> None:
        """Return at that time, or at once where it has passed."""


class Command(Enum):
    """What the listener at the keyboard wants."""

    PAUSE = "pause, or go on"
    STEP = "one sample, while paused"
    QUIT = "end"


def no_command() -> None:
    """Nobody at the keyboard."""


def play(
    session: Session,
    put: Callable[[str, Sample], None],
    *,
    clock: Clock,
    speed: float = 1.0,
    start_s: float = 0.0,
    duration_s: float = math.inf,
    loop: bool = False,
    first_time_ns: int | None = None,
    command: Callable[[], Command | None] = no_command,
) -> int:
    """Give a session's surface samples to `put`, each at its time, and return how many they were.

    `start_s` and `duration_s` are in the session's time, `speed` is session time over clock time.
    Deadlines count from one start, so that delays do not add up; a late sample goes out at once.
    `first_time_ns` moves all time stamps so that the first is this one; their spacing stays, for
    the physics lives in it. With `loop` it begins again for ever, time stamps and sequence numbers
    running on. `command` is asked between samples and while waiting. Raises InputError where there
    is nothing to play.
    """
    pace: _Pace | None = None
    count = 0
    for position_ns, topic, sample in laps(session, start_s, duration_s, loop, first_time_ns):
        pace = pace or _Pace(clock, speed, command, position_ns)
        if not pace.wait(position_ns):
            break
        put(topic, sample)
        count += 1
    return count


class _Pace:
    """Where in the session the clock stands: a straight line from an anchor that only pauses move."""

    def __init__(
        self, clock: Clock, speed: float, command: Callable[[], Command | None], position_ns: int
    ) -> None:
        self._clock = clock
        self._speed = speed
        self._command = command
        self._anchor_ns = clock.now_ns()
        self._position_ns: float = position_ns
        self._paused = False

    def wait(self, position_ns: int) -> bool:
        """Return when the session has come to this position; False where it is to end."""
        while True:
            match self._command():
                case Command.QUIT:
                    return False
                case Command.PAUSE:
                    self._toggle()
                case Command.STEP if self._paused:
                    self._position_ns = max(self._position_ns, position_ns)
                    return True
            now_ns = self._clock.now_ns()
            due_ns = self._due_ns(position_ns)
            if now_ns >= due_ns:
                return True
            self._clock.sleep_until(int(min(due_ns, now_ns + _LOOK_NS)))

    def _due_ns(self, position_ns: int) -> float:
        if self._paused:
            return math.inf
        return self._anchor_ns + math.ceil((position_ns - self._position_ns) / self._speed)

    def _toggle(self) -> None:
        now_ns = self._clock.now_ns()
        if not self._paused:
            self._position_ns += (now_ns - self._anchor_ns) * self._speed
        self._anchor_ns = now_ns
        self._paused = not self._paused
