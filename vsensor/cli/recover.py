"""`vsensor recover`: a torn session mended."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from vsensor.cli.reading import reading


def recover(
    torn: Annotated[Path, typer.Argument(help="A torn session: NAME.mcap.part, or a damaged NAME.mcap.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="The mended one; by default NAME.mcap beside it.")
    ] = None,
) -> None:
    """Write a whole session from what survived of a torn one, which is kept."""
    from vsensor.recording.recover import recover as mend

    with reading(torn, "recovering", Console(stderr=True)):
        recovered = mend(torn, output)
    lost = (
        f"of {torn} {recovered.lost} could not be read" if recovered.lost else f"all of {torn} could be read"
    )
    typer.echo(f"{recovered.messages} messages recovered into {recovered.path}; {lost}")
