"""`vsensor export`: a table made of a session."""

from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from vsensor.cli.reading import reading

if TYPE_CHECKING:
    from vsensor.recording.reader import Session


def export(
    session: Annotated[Path, typer.Argument(help="A recorded session.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="The table: .csv, .parquet or .npz.")],
    surface: Annotated[
        bool, typer.Option("--surface", help="The surface samples, not the estimates.")
    ] = False,
) -> None:
    """Make a table of a session's estimates, or of its surface samples."""
    from vsensor.recording.reader import Session
    from vsensor.tables import check_writable

    check_writable(output)  # refuses another kind of file before the work, not after
    write = _surface if surface else _estimates
    with reading(session, "exporting", Console(stderr=True)):
        recorded = Session(session)
        rows = write(recorded, output)
    if shortfall := recorded.shortfall():
        typer.echo(f"{session} {shortfall}; the table holds what is left of it", err=True)
    typer.echo(f"{rows} rows of {session} exported into {output}")


def _estimates(session: "Session", output: Path) -> int:
    from vsensor.messages import BIT_ESTIMATE
    from vsensor.recording.tabulate import estimate_tables
    from vsensor.tables import ESTIMATE_FIELDS, TableWriter

    with TableWriter(output, tuple(ESTIMATE_FIELDS)) as writer:
        for columns in estimate_tables(session):
            writer.write(columns)
        if not writer.rows:
            raise session.lacks(f"holds no {BIT_ESTIMATE}; --surface exports its surface samples")
    return writer.rows


def _surface(session: "Session", output: Path) -> int:
    import numpy as np

    from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE
    from vsensor.recording.tabulate import surface_tables
    from vsensor.tables import TableWriter, surface_columns

    known, alone = 0, 0
    tables = surface_tables(session)
    first = next(tables, None)
    with TableWriter(output, tuple(surface_columns(first)) if first else ()) as writer:
        for table in chain([first] if first else [], tables):
            has = ~np.isnan([table.motor_torque_nm, table.motor_speed_rad_s])
            known += int(np.count_nonzero(has))
            alone += int(np.count_nonzero(has[0] != has[1]))
            writer.write(surface_columns(table))
        if not known:
            raise session.lacks(f"holds no {SURFACE_TORQUE} and no {SURFACE_SPEED}")
    if alone:
        typer.echo(f"{alone} rows have a sample of one channel alone: the other is left empty", err=True)
    return writer.rows
