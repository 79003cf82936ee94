"""`vsensor paper`: the paper's figures and tables, from our models."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import track

from vsensor.errors import VsensorError


def paper(
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FOLDER", help="Made if it is missing.", file_okay=False)
    ],
) -> None:
    """Write the paper's figures (PNG, SVG), their numbers (CSV) and a page that tells of them (HTML)."""
    console = Console(highlight=False, markup=False, soft_wrap=True)
    with console.status("running the paper's models"):
        try:
            from vsensor.paper.publish import publish
            from vsensor.paper.results import compute
        except ModuleNotFoundError as error:
            raise VsensorError(f"needs {error.name}, an extra: pip install 'vsensor[paper]'") from error
        results = compute()
    watch = partial(
        track, description="drawing", console=console, transient=True, disable=not console.is_terminal
    )
    try:
        page = publish(results, output, watch)
    except OSError as error:
        raise VsensorError(f"{output}: cannot be written: {error.strerror}") from error
    console.print(f"The paper, judged: {page}; its figures and values.csv beside it.")
