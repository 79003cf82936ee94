"""`vsensor tell`: tell a running sensor what only the driller knows."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

from vsensor.cli.options import connected
from vsensor.config import load


def tell(
    config: Annotated[Path, typer.Argument(help="The rig: a TOML file.")],
    words: Annotated[
        list[str], typer.Argument(help="off bottom, on bottom, by depths, longer 28.5 m, shorter 28.5 m.")
    ],
    connect: Annotated[str, typer.Option(help="Where the bus is, such as tcp/127.0.0.1:7447.")] = "",
) -> None:
    """Tell a running sensor that the bit is off bottom, or that the string was made longer."""
    from vsensor.bus import command, open_session

    rig = load(config)
    with open_session(connected(rig.bus, connect), "client") as session:
        done = command(session, rig.prefix, " ".join(words))
    Console().print(escape(done), highlight=False, soft_wrap=True)
