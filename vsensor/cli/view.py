"""`vsensor view`: the live view."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from vsensor.cli.options import connected, rig_name
from vsensor.config import Bus, Rig, TopDrive, View, load


def view(
    config: Annotated[Path | None, typer.Argument(help="The rig; without, the one alive on the bus.")] = None,
    rig: Annotated[str, typer.Option(help="Look at the rig of this name.")] = "",
    connect: Annotated[str, typer.Option(help="Where the bus is, such as tcp/127.0.0.1:7447.")] = "",
    web: Annotated[bool, typer.Option("--web", help="Serve a page for the browser; no window.")] = False,
    save: Annotated[Path | None, typer.Option(help="Write a Rerun file (.rrd); no window.")] = None,
    port: Annotated[
        int | None, typer.Option(help="Port of the page; 9090 if free.", min=1, max=65535)
    ] = None,
    data_port: Annotated[
        int | None, typer.Option(help="Port of the data; 9876 if free.", min=1, max=65535)
    ] = None,
) -> None:
    """Show a running sensor live, until Ctrl-C or until the window is closed."""
    from vsensor.signals import until_signalled
    from vsensor.view import place as places
    from vsensor.view.blueprint import blueprint
    from vsensor.view.ears import Ears
    from vsensor.view.live import Live, show
    from vsensor.view.screen import Screen
    from vsensor.view.stream import Stream

    say = partial(Console().print, markup=False, highlight=False, soft_wrap=True)
    known = load(config) if config else None
    bus, prefix = _source(known, rig, connect)
    drive = known.top_drive if known else TopDrive()
    layout = blueprint((known.view if known else View()).history)
    place = places.choose(web=web, save=save, page_port=port, data_port=data_port, say=say)
    with (
        until_signalled() as stopped,
        Screen(prefix or "vsensor", layout, place) as screen,
        Ears(bus, prefix, say) as ears,
    ):
        say(place.words())
        show(Live(ears, screen, partial(Stream, drive.gear_ratio, drive.efficiency)), place, stopped, say)


def _source(known: Rig | None, rig: str, connect: str) -> tuple[Bus, str | None]:
    """The bus, and the rig's prefix on it; none where any rig will do."""
    bus = known.bus if known else Bus()
    bus = connected(bus, connect)
    if rig:
        return bus, bus.prefix.replace("{rig}", rig_name(rig))
    return bus, known.prefix if known else None
