"""The player's line at the foot of a terminal: where it is, and which keys it hears."""

import math
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

if TYPE_CHECKING:
    from vsensor.recording.course import Course, Leg
    from vsensor.recording.player import Progress as Played

_EVERY_S = 0.1


class Screen:
    """Shows the progress where there is a terminal; says which session begins, and after what gap."""

    def __init__(self, console: Console, course: "Course", prefix: str, speed: float, keys: bool) -> None:
        from vsensor.recording.keyboard import HELP

        self._course = course
        self._leg: Leg = course.legs[0]
        self._due = 0.0
        self._newest: Played | None = None
        # The player draws: a thread that did it would hold the interpreter while a message is due.
        self._progress = Progress(
            TextColumn("{task.fields[state]} {task.fields[at]}"),
            BarColumn(bar_width=None),
            TextColumn("{task.fields[rest]}"),
            console=console,
            auto_refresh=False,
            transient=True,
            disable=not console.is_terminal,
            expand=True,
        )
        length_s = course.length_ns / 1e9
        times = "as fast as it goes" if math.isinf(speed) else f"×{speed:g}"
        self._rest = f"{_clock(length_s)}  {times}  {{count}} on {prefix}" + (f"  ({HELP})" if keys else "")
        self._task = self._progress.add_task(
            "", total=max(length_s, 1e-9), state="▶", at=_clock(0.0), rest=""
        )

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._newest is not None:  # what came since the last drawing
            self._draw(self._newest)
        self._progress.stop()

    def show(self, played: "Played") -> None:
        """Hear how far the player is."""
        self._newest = played
        if time.monotonic() >= self._due:
            self._due = time.monotonic() + _EVERY_S
            self._draw(played)

    def _draw(self, played: "Played") -> None:
        self._name_sessions(self._course.leg(played.position_s * 1e9))
        self._progress.update(
            self._task,
            completed=played.position_s,
            state="⏸" if played.paused else "▶",
            at=_clock(played.position_s),
            rest=self._rest.format(count=played.messages),
        )
        self._progress.refresh()

    def _name_sessions(self, leg: "Leg") -> None:
        """Say which sessions were begun on the way to this one; of one gone back to, its name."""
        passed = [
            each for each in self._course.legs if self._leg.position_ns < each.position_ns <= leg.position_ns
        ]
        for each in passed:
            self.say(f"{each.session.path}, {_gap(each.gap_s)}")
        if leg.position_ns < self._leg.position_ns:
            self.say(f"{leg.session.path}")
        self._leg = leg

    def say(self, text: str) -> None:
        """Say something above the line."""
        self._progress.console.print(text, markup=False, highlight=False, soft_wrap=True)


def _clock(seconds: float) -> str:
    minutes, rest = divmod(max(seconds, 0.0), 60)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours}:{minutes:02d}:{rest:04.1f}" if hours else f"{minutes}:{rest:04.1f}"


def _gap(seconds: float) -> str:
    if seconds < 0:
        return f"begins {-seconds:.1f} s before the end of the one before"
    return "goes on from there" if seconds < 1 else f"after a gap of {_clock(seconds)}"
