"""`vsensor import`: a session made of a table."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import track

from vsensor import __version__
from vsensor.config import load


def import_(
    source: Annotated[Path, typer.Argument(metavar="INPUT", help="Surface samples: .csv or .parquet.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="The session: .mcap.")],
    rig: Annotated[str, typer.Option(help="The rig's name; by default the configuration's.")] = "",
    config: Annotated[Path | None, typer.Option(help="The rig's configuration, to go with it.")] = None,
    time_column: Annotated[str, typer.Option(help="What the table calls the time.")] = "time_s",
    torque_column: Annotated[str, typer.Option(help="What it calls the torque.")] = "motor_torque_nm",
    speed_column: Annotated[str, typer.Option(help="What it calls the speed.")] = "motor_speed_rad_s",
    time_unit: Annotated[str, typer.Option(help='Unit of the time, such as "ms".')] = "s",
    torque_unit: Annotated[str, typer.Option(help='Unit of the torque, such as "kft*lbf".')] = "N*m",
    speed_unit: Annotated[str, typer.Option(help='Unit of the speed, such as "rpm".')] = "rad/s",
) -> None:
    """Make a session of a table of surface torque and speed."""
    from vsensor.recording.writer import SessionWriter
    from vsensor.tables import read_surface, surface_samples

    known = load(config) if config else None
    table = read_surface(
        source,
        columns={"time_s": time_column, "motor_torque_nm": torque_column, "motor_speed_rad_s": speed_column},
        units={"time_s": time_unit, "motor_torque_nm": torque_unit, "motor_speed_rad_s": speed_unit},
    )
    console = Console(stderr=True)
    with SessionWriter(
        output,
        configuration=config.read_text(encoding="utf-8") if config else "",
        metadata={
            "rig": rig or (known.rig.name if known else ""),
            "vsensor": __version__,
            "imported_from": source.name,
        },
        compression="zstd",
    ) as writer:
        rows = track(
            surface_samples(table),
            f"importing {source.name}",
            total=2 * len(table.time_s),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        for topic, sample in rows:
            writer.write(topic, sample.SerializeToString(), sample.time_ns, sample.time_ns, sample.sequence)
    typer.echo(f"{len(table.time_s)} rows of {source} imported into {output}")
