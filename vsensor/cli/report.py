"""`vsensor report`: what happened in a session, as one page."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from vsensor.cli.reading import reading
from vsensor.errors import ConfigError


def report(
    session: Annotated[Path, typer.Argument(help="A recorded session.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="The page: .html.")],
) -> None:
    """Tell what happened in a session, in words, key figures and plots, on one page that needs no network."""
    if output.suffix != ".html":
        raise ConfigError(f"{output}: a report's name must end in .html")
    try:
        from vsensor.report.report import report as tell
        from vsensor.report.report import write
    except ModuleNotFoundError as error:
        if error.name is None or not error.name.startswith("plotly"):
            raise
        raise ConfigError("a report needs Plotly: pip install 'vsensor[report]'") from error
    from vsensor.recording.reader import Session

    with reading(session, "reading", Console(stderr=True)):
        write(output, tell(Session(session)))
    typer.echo(f"{session} told in {output}")
