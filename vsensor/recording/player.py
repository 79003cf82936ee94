"""Recorded messages given out again at the pace at which they were taken."""

import math
from collections.abc import Callable
from enum import Enum
from typing import NamedTuple, Protocol

from vsensor.grid import NS
from vsensor.messages import Message
from vsensor.recording.course import Course
from vsensor.recording.laps import Laps

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
    STEP = "one message, while paused"
    QUIT = "end"
    BACK = "10 s back"
    FORWARD = "10 s forward"
    FAR_BACK = "a minute back"
    FAR_FORWARD = "a minute forward"


SEEK_S = {
    Command.BACK: -10.0,
    Command.FORWARD: 10.0,
    Command.FAR_BACK: -60.0,
    Command.FAR_FORWARD: 60.0,
}


class Progress(NamedTuple):
    """How far the player is."""

    position_s: float
    """On the course."""
    messages: int
    paused: bool


def no_command() -> None:
    """Nobody at the keyboard."""


def no_show(_progress: Progress) -> None:
    """Nobody who looks."""


def no_return() -> None:
    """Nothing to be set back."""


def play(
    course: Course,
    put: Callable[[str, Message], object],
    *,
    clock: Clock,
    speed: float = 1.0,
    start_s: float = 0.0,
    end_s: float = math.inf,
    loop: bool = False,
    stamp: Callable[[], int] | None = None,
    command: Callable[[], Command | None] = no_command,
    show: Callable[[Progress], object] = no_show,
    again: Callable[[], object] = no_return,
) -> int:
    """Give a course's messages to `put`, each at its time, and return how many they were.

    `start_s` and `end_s` are in the course's time, `speed` is its time over clock time, infinite: as fast
    as it goes. Deadlines count from one start, so that delays do not add up; a late message goes out at once.
    `stamp` tells the present, for time stamps that begin now: their spacing stays, for the physics lives in
    it. With `loop` it begins again for ever, time stamps and sequence numbers running on. `command` is asked
    between messages and while waiting, and `show` told as often; `again` is called before each later lap.
    Raises InputError where there is nothing to play.
    """
    laps = Laps(course, start_s, end_s, loop, stamp)
    pace: _Pace | None = None
    count, lap = 0, 1

    def look() -> None:
        if pace is not None:
            show(Progress(laps.on_course(pace.at_ns) / NS, count, pace.paused))

    for position_ns, topic, message in laps:
        pace = pace or _Pace(clock, speed, position_ns)
        told = pace.wait(position_ns, command, look)
        if told is Command.QUIT:
            break
        if told is not None:
            pace.jump(laps.seek(pace.at_ns + SEEK_S[told] * NS))
            continue
        if laps.number > lap:
            lap = laps.number
            again()
        put(topic, message)
        count += 1
        look()
    return count


class _Pace:
    """Where on the course the clock stands: a straight line from an anchor that pauses and seeks move."""

    def __init__(self, clock: Clock, speed: float, position_ns: int) -> None:
        self.paused = False
        self._clock = clock
        self._speed = speed
        self._newest_ns = position_ns
        self.jump(position_ns)

    @property
    def at_ns(self) -> float:
        """The position of this moment; as fast as it goes, that of the newest message."""
        if self.paused:
            return self._position_ns
        if math.isinf(self._speed):
            return self._newest_ns
        return self._position_ns + (self._clock.now_ns() - self._anchor_ns) * self._speed

    def jump(self, position_ns: float) -> None:
        """Stand at another position from now on."""
        self._position_ns: float = position_ns
        self._anchor_ns = self._clock.now_ns()

    def wait(
        self, position_ns: int, command: Callable[[], Command | None], look: Callable[[], object]
    ) -> Command | None:
        """Return when the clock has come to this position, or with a command to be elsewhere."""
        while True:
            match told := command():
                case Command.PAUSE:
                    self.jump(self.at_ns)
                    self.paused = not self.paused
                case Command.STEP if self.paused:
                    self._position_ns = max(self._position_ns, position_ns)
                    break
                case Command.STEP | None:
                    pass
                case _:
                    return told
            now_ns = self._clock.now_ns()
            due_ns = self._due_ns(position_ns)
            if now_ns >= due_ns:
                break
            look()
            self._clock.sleep_until(int(min(due_ns, now_ns + _LOOK_NS)))
        self._newest_ns = position_ns
        return None

    def _due_ns(self, position_ns: int) -> float:
        if self.paused:
            return math.inf
        return self._anchor_ns + math.ceil((position_ns - self._position_ns) / self._speed)
