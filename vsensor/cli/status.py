"""`vsensor status`: ask a running sensor how it is, and show it."""

import sys
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.live import Live

from vsensor.cli.options import connected
from vsensor.cli.wide import wide_console
from vsensor.config import load

PERIOD_S = 0.5


def status(
    config: Annotated[Path, typer.Argument(help="The rig: a TOML file.")],
    connect: Annotated[str, typer.Option(help="Where the bus is, such as tcp/127.0.0.1:7447.")] = "",
    once: Annotated[
        bool, typer.Option("--once", help="Show it once; so it is where there is no terminal.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the status once, as JSON.")] = False,
) -> None:
    """Show how a running sensor is, live, until Ctrl-C."""
    from google.protobuf.json_format import MessageToJson

    from vsensor.bus import Feed, ask_status, open_session
    from vsensor.cli.panel import Panel
    from vsensor.signals import until_signalled

    rig = load(config)
    with open_session(connected(rig.bus, connect), "client") as session:
        feed = Feed(session, rig.prefix)
        panel = Panel(ask_status(session, rig.prefix))
        if as_json:
            typer.echo(MessageToJson(panel.status, preserving_proto_field_name=True))
            return
        if once or not sys.stdout.isatty():
            time.sleep(PERIOD_S)
            panel.hear_all(feed.drain())
            wide_console().print(panel.shown())
            return
        with until_signalled() as stopped, Live(panel.shown(), screen=True, auto_refresh=False) as live:
            while not stopped():
                panel.hear_all(feed.drain())
                live.update(panel.shown(), refresh=True)
                time.sleep(PERIOD_S)
