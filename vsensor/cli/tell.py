"""`vsensor tell`: tell a running sensor what only the driller knows, or what to record."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

from vsensor.cli.options import connected
from vsensor.commands import HELP
from vsensor.config import load


def tell(
    config: Annotated[Path, typer.Argument(help="The rig: a TOML file.")],
    words: Annotated[list[str], typer.Argument(help=f"{HELP[0].upper()}{HELP[1:]}.")],
    connect: Annotated[str, typer.Option(help="Where the bus is, such as tcp/127.0.0.1:7447.")] = "",
) -> None:
    """Tell a running sensor that the bit is off bottom, that the string has grown, or what to record."""
    from vsensor.bus import command, open_session

    rig = load(config)
    with open_session(connected(rig.bus, connect), "client") as session:
        done = command(session, rig.prefix, " ".join(words))
    Console().print(escape(done), highlight=False, soft_wrap=True)
