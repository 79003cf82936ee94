"""`vsensor replay`: a session's surface samples published as if live."""

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.status import Status

from vsensor.cli.options import connected, rig_name
from vsensor.config import Bus, loads
from vsensor.errors import ConfigError

if TYPE_CHECKING:
    from vsensor.messages import Sample
    from vsensor.recording.reader import Session

_KEYS = "space pauses, . steps, q ends"


def replay(
    session: Annotated[Path, typer.Argument(help="A recorded session.")],
    rig: Annotated[str, typer.Option(help="Publish under this rig's name, not the recorded one.")] = "",
    connect: Annotated[
        str, typer.Option(help="Where the sensor listens; tcp/127.0.0.1:7447 by default.")
    ] = "",
    speed: Annotated[float, typer.Option(help="Times as fast.", min=0.001)] = 1.0,
    start: Annotated[float, typer.Option(help="Seconds into the session.", min=0)] = 0.0,
    duration: Annotated[float | None, typer.Option(help="Seconds of the session.", min=0)] = None,
    loop: Annotated[bool, typer.Option("--loop", help="Begin again for ever, time running on.")] = False,
    present: Annotated[
        bool, typer.Option("--present", help="Time stamps that begin now, at their recorded spacing.")
    ] = False,
) -> None:
    """Publish a session's surface samples as if live. At a terminal space pauses, . steps, q ends."""
    from vsensor.bus import Outbox, open_session, wait_for_sensor
    from vsensor.recording.keyboard import Keyboard
    from vsensor.recording.player import Command, play
    from vsensor.recording.reader import Session
    from vsensor.service.pace import MonotonicClock
    from vsensor.signals import until_signalled

    recorded = Session(session)
    bus, prefix = _bus(recorded, rig, connect)
    console = Console(stderr=True)
    with until_signalled() as stopped, open_session(bus, "client") as zenoh:
        if not wait_for_sensor(zenoh, prefix):
            typer.echo(f"nobody listens on {prefix} yet; publishing all the same", err=True)
        with Keyboard() as keyboard, console.status(prefix) as status:
            keys = f" ({_KEYS})" if keyboard.listening else ""
            outbox = Outbox(zenoh, prefix, reliable=True)
            count = play(
                recorded,
                _shown(outbox.put, status, f"on {prefix}{keys}"),
                clock=MonotonicClock(),
                speed=speed,
                start_s=start,
                duration_s=math.inf if duration is None else duration,
                loop=loop,
                first_time_ns=time.time_ns() if present else None,
                command=lambda: Command.QUIT if stopped() else keyboard.command(),
            )
    typer.echo(f"{count} samples of {session} published on {prefix}")


def _bus(session: "Session", rig: str, connect: str) -> tuple[Bus, str]:
    """Where to publish, and under which prefix: as asked, else as recorded."""
    recorded = (
        loads(session.configuration, f"{session.path}: configuration") if session.configuration else None
    )
    name = rig_name(rig) if rig else session.metadata.get("rig") or (recorded.rig.name if recorded else "")
    if not name:
        raise ConfigError(f"{session.path}: does not say which rig it is of: name one with --rig")
    # The recorded endpoint is where that sensor listened then, a demonstration's on a port of the day.
    bus = connected(Bus(prefix=recorded.bus.prefix) if recorded else Bus(), connect)
    return bus, bus.prefix.replace("{rig}", name)


def _shown(
    put: "Callable[[str, Sample], object]", status: Status, rest: str
) -> "Callable[[str, Sample], None]":
    """Publish and count, and say how far we are, some times a second."""
    count = 0
    first_ns: int | None = None
    due = 0.0

    def publish(topic: str, sample: "Sample") -> None:
        nonlocal count, first_ns, due
        put(topic, sample)
        count += 1
        first_ns = sample.time_ns if first_ns is None else first_ns
        if time.monotonic() >= due:
            due = time.monotonic() + 0.2
            status.update(f"{(sample.time_ns - first_ns) / 1e9:.1f} s, {count} samples {rest}")

    return publish
