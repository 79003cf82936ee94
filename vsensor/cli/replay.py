"""`vsensor replay`: sessions published as if live."""

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from vsensor.cli.options import connected, rig_name
from vsensor.cli.printable import printable
from vsensor.config import Bus, loads
from vsensor.errors import BusError, ConfigError

if TYPE_CHECKING:
    import zenoh

    from vsensor.messages import Message
    from vsensor.recording.course import Course
    from vsensor.recording.reader import Session

    Put = Callable[[str, Message], object]

FASTEST = "max"
HIGHEST = 1e6
"""Faster than any machine publishes."""


def _speed(text: str) -> float:
    try:
        speed = math.inf if text == FASTEST else float(text)
    except ValueError:
        speed = 0.0
    if not (0 < speed <= HIGHEST or speed == math.inf):
        raise typer.BadParameter(
            f"{text!r} is no speed: a number such as 0.1 or 20, up to {HIGHEST:g}, or {FASTEST}"
        )
    return speed


def replay(
    sessions: Annotated[
        list[Path],
        typer.Argument(metavar="SESSION...", help="Recorded, played one after the other."),
    ],
    rig: Annotated[str, typer.Option(help="Publish under this rig's name, not the recorded one.")] = "",
    connect: Annotated[
        str, typer.Option(help="Where the sensor listens; tcp/127.0.0.1:7447 by default.")
    ] = "",
    speed: Annotated[
        float, typer.Option(parser=_speed, metavar="TIMES", help=f"Times as fast, or {FASTEST}.")
    ] = 1.0,
    start: Annotated[float, typer.Option(help="Seconds into the first session.", min=0)] = 0.0,
    duration: Annotated[float, typer.Option(help="Seconds to play.", min=0)] = math.inf,
    until: Annotated[float, typer.Option(help="Seconds into the first session to end at.", min=0)] = math.inf,
    loop: Annotated[bool, typer.Option("--loop", help="Begin again for ever, time running on.")] = False,
    present: Annotated[
        bool, typer.Option("--present", help="Time stamps that begin now, at their recorded spacing.")
    ] = False,
    topics: Annotated[
        str, typer.Option(help="What to publish, parted by commas; by default the surface channels.")
    ] = "",
    commands: Annotated[
        bool, typer.Option("--commands", help="Give the recorded commands to the sensor again.")
    ] = False,
    max_gap: Annotated[float, typer.Option(help="Seconds to wait between sessions at most.", min=0)] = 10.0,
) -> None:
    """Publish sessions as if live. At a terminal space pauses, . steps, the arrows seek, q ends."""
    from vsensor.bus import open_session, wait_for_sensor
    from vsensor.cli.screen import Screen
    from vsensor.messages import SENSOR_EVENT, SURFACE_TOPICS
    from vsensor.recording.keyboard import Keyboard
    from vsensor.recording.player import Command, play
    from vsensor.recording.reader import Session
    from vsensor.service.pace import MonotonicClock
    from vsensor.signals import until_signalled

    recorded = [Session(path) for path in sessions]
    chosen = _topics(topics) if topics else SURFACE_TOPICS
    bus, prefix = _bus(recorded, rig, connect)
    course = _course(recorded, (*chosen, SENSOR_EVENT) if commands else chosen, max_gap)
    console = Console(stderr=True)
    with until_signalled() as stopped, open_session(bus, "client") as zenoh:
        if not wait_for_sensor(zenoh, prefix):
            typer.echo(f"nobody listens on {prefix} yet; publishing all the same", err=True)
        with Keyboard() as keyboard, Screen(console, course, prefix, speed, keyboard.listening) as screen:
            told = _Commanding(zenoh, prefix, screen.say) if commands else None
            put, again = _outlets(zenoh, prefix, told, SENSOR_EVENT in chosen)
            count = play(
                course,
                put,
                clock=MonotonicClock(),
                speed=speed,
                start_s=start,
                end_s=min(start + duration, until),
                loop=loop,
                stamp=time.time_ns if present else None,
                command=lambda: Command.QUIT if stopped() else keyboard.command(),
                show=screen.show,
                again=again,
            )
    what = "samples" if chosen is SURFACE_TOPICS and not commands else "messages"
    typer.echo(f"{count} {what} of {', '.join(map(str, sessions))} published on {prefix}")


def _topics(text: str) -> tuple[str, ...]:
    """Topics by name; ConfigError for what is not published on a bus."""
    from vsensor.messages import IN_SESSIONS_ALONE, message_type

    topics = tuple(topic.strip() for topic in text.split(",") if topic.strip())
    for topic in topics:
        if message_type(topic) is None or topic in IN_SESSIONS_ALONE:
            raise ConfigError(
                f"--topics: {topic!r} is on no bus: surface/torque and bit/estimate, for example, are"
            )
    return topics


def _course(sessions: "list[Session]", topics: tuple[str, ...], max_gap: float) -> "Course":
    """What is played of the sessions; of one that holds nothing of it is said that it is passed over."""
    from vsensor.recording.course import Course

    course = Course(sessions, topics, max_gap)
    for session in course.passed_over:
        typer.echo(f"{session.path} holds none of {', '.join(topics)}, and is passed over", err=True)
    return course


def _outlets(
    zenoh: "zenoh.Session", prefix: str, told: "_Commanding | None", events: bool
) -> "tuple[Put, Callable[[], None]]":
    """Where messages go, and what is done before a lap begins again."""
    from vsensor.bus import SURFACE_CACHE, Outbox
    from vsensor.recording.player import no_return

    put: Put = Outbox(zenoh, prefix, reliable=True, cache=SURFACE_CACHE).put
    return (told.putting(put, publish=events), told.take_back) if told else (put, no_return)


def _bus(sessions: "list[Session]", rig: str, connect: str) -> tuple[Bus, str]:
    """Where to publish, and under which prefix: as asked, else as recorded."""
    session = sessions[0]
    recorded = (
        loads(session.configuration, f"{session.path}: configuration") if session.configuration else None
    )
    name = rig or session.metadata.get("rig") or (recorded.rig.name if recorded else "")
    if not name:
        raise ConfigError(f"{session.path}: does not say which rig it is of: name one with --rig")
    name = rig_name(name, "--rig" if rig else f"{session.path}: the recorded rig")
    for other in sessions[1:]:
        if not rig and other.metadata.get("rig") != name:
            raise ConfigError(f"{other.path}: is not of the rig {name}: name one for all with --rig")
    # The recorded endpoint is where that sensor listened then, a demonstration's on a port of the day.
    bus = connected(Bus(prefix=recorded.bus.prefix) if recorded else Bus(), connect)
    return bus, bus.prefix.replace("{rig}", name)


class _Commanding:
    """Gives recorded commands to the sensor again; what it answers is said."""

    def __init__(self, session: "zenoh.Session", prefix: str, say: Callable[[str], None]) -> None:
        from vsensor.commands import Undo

        self._session, self._prefix, self._say = session, prefix, say
        self._undo = Undo()

    def putting(self, put: "Put", publish: bool) -> "Put":
        """Publish, and give what is a command; other events too only where asked to `publish` them."""
        from vsensor.commands import COMMAND
        from vsensor.messages import Event

        def give(topic: str, message: "Message") -> None:
            if isinstance(message, Event):
                if message.name == COMMAND and self._obeyed(message.text):
                    self._undo.note(message.text)
                if not publish:
                    return
            put(topic, message)

        return give

    def take_back(self) -> None:
        """Have the sensor as it was before the lap's commands."""
        for words in self._undo.words():
            self._obeyed(words)

    def _obeyed(self, words: str) -> bool:
        from vsensor.bus import command

        try:
            self._say(f'"{printable(words)}": {command(self._session, self._prefix, words)}')
        except BusError as error:
            self._say(f'"{printable(words)}" is refused: {error}')
            return False
        return True
