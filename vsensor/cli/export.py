"""`vsensor export`: a table made of a session."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import track

from vsensor.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vsensor.recording.reader import Record, Session


def export(
    session: Annotated[Path, typer.Argument(help="A recorded session.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="The table: .csv or .parquet.")],
    surface: Annotated[
        bool, typer.Option("--surface", help="The surface samples, not the estimates.")
    ] = False,
) -> None:
    """Make a table of a session's estimates, or of its surface samples."""
    from vsensor.recording.reader import Session
    from vsensor.tables import is_csv

    is_csv(output)  # refuses another kind of file before the work, not after
    write = _surface if surface else _estimates
    rows = write(Session(session), output)
    typer.echo(f"{rows} rows of {session} exported into {output}")


def _estimates(session: "Session", output: Path) -> int:
    from vsensor.messages import BIT_ESTIMATE, Estimate
    from vsensor.recording.tabulate import estimate_columns
    from vsensor.tables import write_estimates

    records = _tracked(session, BIT_ESTIMATE)
    columns = estimate_columns(r.message for r in records if isinstance(r.message, Estimate))
    rows = len(columns["time_s"])
    if not rows:
        raise InputError(f"{session.path}: holds no {BIT_ESTIMATE}; --surface exports its surface samples")
    write_estimates(output, columns)
    return rows


def _surface(session: "Session", output: Path) -> int:
    import numpy as np

    from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE
    from vsensor.recording.tabulate import surface_table
    from vsensor.tables import write_surface

    table = surface_table(_tracked(session, SURFACE_TORQUE, SURFACE_SPEED))
    rows = len(table.time_s)
    if not rows:
        raise InputError(f"{session.path}: holds no {SURFACE_TORQUE} and no {SURFACE_SPEED}")
    write_surface(output, table)
    alone = int(np.isnan(table.motor_torque_nm).sum() + np.isnan(table.motor_speed_rad_s).sum())
    if alone:
        typer.echo(f"{alone} rows have a sample of one channel alone: the other is left empty", err=True)
    return rows


def _tracked(session: "Session", *topics: str) -> "Iterator[Record]":
    console = Console(stderr=True)
    counts = {topic.topic: topic.messages for topic in session.summary().topics}
    yield from track(
        session.messages(topics),
        f"reading {session.path.name}",
        total=sum(counts.get(topic, 0) for topic in topics),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
