"""`vsensor view`: the live view, and a recorded session in the same layout."""

import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.console import Console
from rich.progress import track

from vsensor.cli.options import connected, rig_name
from vsensor.config import Bus, Rig, SpeedUnit, TopDrive, TorqueUnit, View, load, loads
from vsensor.errors import ConfigError, InputError, VsensorError

if TYPE_CHECKING:
    from vsensor.messages import Message
    from vsensor.recording.reader import Session
    from vsensor.view.live import Show
    from vsensor.view.place import Place
    from vsensor.view.screen import Screen
    from vsensor.view.units import Units

Say = Callable[[str], None]

BEHIND = 10
"""So much nicer are the view, and the viewer that it starts, than a sensor on the same machine."""


def view(
    config: Annotated[Path | None, typer.Argument(help="The rig; without, the one alive on the bus.")] = None,
    rig: Annotated[str, typer.Option(help="Look at the rig of this name.")] = "",
    connect: Annotated[str, typer.Option(help="Where the bus is, such as tcp/127.0.0.1:7447.")] = "",
    session: Annotated[Path | None, typer.Option(help="Look at a recorded session instead.")] = None,
    web: Annotated[bool, typer.Option("--web", help="Serve a page for the browser; no window.")] = False,
    save: Annotated[Path | None, typer.Option(help="Write a Rerun file (.rrd); no window.")] = None,
    tab: Annotated[
        Literal["driller", "engineer", "service"], typer.Option(help="The tab that is open at first.")
    ] = "driller",
    speed_unit: Annotated[SpeedUnit | None, typer.Option(help="As configured; else rpm.")] = None,
    torque_unit: Annotated[TorqueUnit | None, typer.Option(help="As configured; else kN·m.")] = None,
    port: Annotated[
        int | None, typer.Option(help="Port of the page; 9090 if free.", min=1, max=65535)
    ] = None,
    data_port: Annotated[
        int | None, typer.Option(help="Port of the data; 9876 if free.", min=1, max=65535)
    ] = None,
    bind: Annotated[
        str, typer.Option(help="Serve at this address of the machine; 0.0.0.0 for all of them.")
    ] = "127.0.0.1",
) -> None:
    """Show a running sensor live, or a recorded session, until Ctrl-C or until the window is closed."""
    from vsensor.signals import until_signalled

    try:
        from vsensor.view import place as places
        from vsensor.view.blueprint import blueprint
        from vsensor.view.screen import Screen
        from vsensor.view.units import Units
    except ModuleNotFoundError as error:
        raise VsensorError(f"needs {error.name}, an extra: pip install 'vsensor[view]'") from error

    say: Say = partial(Console().print, markup=False, highlight=False, soft_wrap=True)
    recorded = _recorded(session, rig, connect, save)
    known = load(config) if config else _configuration(recorded, say)
    how = known.view if known else View()
    units = Units(speed_unit or how.speed_unit, torque_unit or how.torque_unit)
    bus, prefix = _source(known, rig, connect)
    os.nice(BEHIND)
    with (
        until_signalled() as stopped,
        places.choose(web=web, save=save, page_port=port, data_port=data_port, bind=bind, say=say) as place,
        Screen(
            session.name if session else prefix or "vsensor",
            partial(blueprint, how.history, units, tab=tab),
            place,
            live=recorded is None,
        ) as screen,
    ):
        show = _show(screen, units, known.top_drive if known else TopDrive(), how.history)
        if recorded:
            _show_session(recorded, known, show, place, stopped, say)
        else:
            _show_live(bus, prefix, show, place, stopped, say)


def _show(screen: "Screen", units: "Units", drive: TopDrive, history: float) -> "Show":
    from vsensor.view.live import Show
    from vsensor.view.plots import Drive
    from vsensor.view.stream import Stream

    return Show(screen, partial(Stream, units, Drive(drive.gear_ratio, drive.efficiency), history))


def _show_live(
    bus: Bus, prefix: str | None, show: "Show", place: "Place", stopped: Callable[[], bool], say: Say
) -> None:
    from vsensor.view.ears import Ears
    from vsensor.view.live import Live, run

    say(place.words())
    say("Ctrl-C ends it")
    with Ears(bus, prefix, say) as ears:
        run(Live(ears, show).turn, place, stopped, say)


def _show_session(
    session: "Session",
    known: Rig | None,
    show: "Show",
    place: "Place",
    stopped: Callable[[], bool],
    say: Say,
) -> None:
    """All of it at once; then it is there to look at until the end."""
    from vsensor.view.live import run

    show.fill(_messages(session, known))
    if not show.stream.begun:
        raise InputError(
            f"{session.path}: holds no ticks of a sensor, hence no estimates to show; "
            "those of a daemon's session are shown, such as one that heard this session replayed"
        )
    say(place.words())
    if place.kind != "file":
        say("Ctrl-C ends it")
        run(lambda: None, place, stopped, say)


def _messages(session: "Session", known: Rig | None) -> "Iterator[Message]":
    """What is drawn of a session; before it, what the string is, which older sessions do not tell."""
    from vsensor.view.stream import TOPICS

    if known:
        from vsensor.service.describe import describe

        yield describe(known, known.string)
    console = Console(stderr=True)
    total = sum(topic.messages for topic in session.summary().topics if topic.topic in TOPICS)
    for record in track(
        session.messages(TOPICS),
        "drawing",
        total,
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ):
        yield record.message


def _recorded(path: Path | None, rig: str, connect: str, save: Path | None) -> "Session | None":
    from vsensor.recording.reader import Session

    if save and save.suffix != ".rrd":
        raise ConfigError(f"--save {save}: must end in .rrd")
    if path and (rig or connect):
        raise ConfigError(f"--session {path}: is a file; --rig and --connect are for a running sensor")
    return Session(path) if path else None


def _configuration(session: "Session | None", say: Say) -> Rig | None:
    """The session's own; one that this version does not read is done without."""
    if session is None or session.configuration is None:
        return None
    try:
        return loads(session.configuration, f"{session.path}: its configuration")
    except ConfigError as error:
        say(f"{error}\nThe session is shown without it.")
        return None


def _source(known: Rig | None, rig: str, connect: str) -> tuple[Bus, str | None]:
    """The bus, and the rig's prefix on it; none where any rig will do."""
    bus = known.bus if known else Bus()
    bus = connected(bus, connect)
    if rig:
        return bus, bus.prefix.replace("{rig}", rig_name(rig))
    return bus, known.prefix if known else None
