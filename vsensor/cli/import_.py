"""`vsensor import`: a session made of a table."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from vsensor import __version__
from vsensor.cli.options import NULL, rig_name
from vsensor.cli.reading import reading
from vsensor.config import effective_toml, load

if TYPE_CHECKING:
    from vsensor.recording.writer import SessionWriter
    from vsensor.tables import SurfaceTable


def import_(
    source: Annotated[
        Path,
        typer.Argument(metavar="INPUT", help="Surface samples: .csv, .parquet, .feather, .arrow, .npz."),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="The session: .mcap.")],
    rig: Annotated[str, typer.Option(help="The rig's name; by default the configuration's.")] = "",
    config: Annotated[Path | None, typer.Option(help="The rig's configuration, to go with it.")] = None,
    time_column: Annotated[
        str, typer.Option(help="What the table calls the time; by default time_ns, or else time_s.")
    ] = "",
    torque_column: Annotated[str, typer.Option(help="What it calls the torque.")] = "motor_torque_nm",
    speed_column: Annotated[str, typer.Option(help="What it calls the speed.")] = "motor_speed_rad_s",
    date_column: Annotated[
        str, typer.Option(help="What it calls the date, where the time column has only the time of day.")
    ] = "",
    time_unit: Annotated[
        str, typer.Option(help='Unit of a time in numbers, such as "ms", else s; text is read as ISO 8601.')
    ] = "",
    time_format: Annotated[
        str, typer.Option(help='Of text that is not ISO 8601, as strptime: "%d.%m.%Y %H:%M:%S".')
    ] = "",
    time_zone: Annotated[
        str, typer.Option(help='Where a clock hangs that tells no offset, such as "Europe/Oslo".')
    ] = "UTC",
    torque_unit: Annotated[str, typer.Option(help='Unit of the torque, such as "kft*lbf", else N*m.')] = "",
    speed_unit: Annotated[str, typer.Option(help='Unit of the speed, such as "rpm", else rad/s.')] = "",
    bit_depth_column: Annotated[
        str,
        typer.Option(
            help="What it calls the bit's depth; by default bit_depth_m, if it has it: off bottom the sensor "
            "tares itself."
        ),
    ] = "",
    hole_depth_column: Annotated[str, typer.Option(help="And the hole's; by default hole_depth_m.")] = "",
    depth_unit: Annotated[str, typer.Option(help='Unit of the depths, such as "ft", else m.')] = "",
    null: Annotated[list[float], NULL] = [],  # noqa: B006, typer copies it
    skip_lines: Annotated[int, typer.Option(min=0, help="Lines of a .csv before its header.")] = 0,
    units_line: Annotated[
        bool,
        typer.Option("--units-line", help="The line under the header tells units, where no option does."),
    ] = False,
    resample: Annotated[
        str, typer.Option(help='Lay the samples on a grid of this rate, such as "100 Hz", by straight lines.')
    ] = "",
) -> None:
    """Make a session of a table of surface torque and speed, and of depths if it has them."""
    from vsensor.tables import Findings, Head, Layout, TimeForm, surface_pieces
    from vsensor.tables.resample import resampled

    known = load(config) if config else None
    layout = Layout(
        time=time_column,
        torque=torque_column,
        speed=speed_column,
        date=date_column,
        form=TimeForm(time_unit, time_format, time_zone).checked(),
        torque_unit=torque_unit,
        speed_unit=speed_unit,
        bit_depth=bit_depth_column,
        hole_depth=hole_depth_column,
        depth_unit=depth_unit,
        nulls=tuple(null),
        head=Head(skip_lines, units_line),
    )
    findings = Findings()
    pieces = surface_pieces(source, layout, whole=bool(resample), findings=findings)
    if resample:
        pieces = resampled(pieces, resample)
    metadata = {
        "rig": rig_name(rig) if rig else known.rig.name if known else "",
        "vsensor": __version__,
        "imported_from": source.name,
        **({"resampled_to": resample} if resample else {}),
    }
    with reading(source, "importing", Console(stderr=True)):
        rows = _session(output, effective_toml(known) if known else "", metadata, pieces)
    for line in findings.words():
        typer.echo(f"{source}: {line}", err=True)
    typer.echo(f"{rows} rows of {source} imported into {output}")


def _session(
    output: Path, configuration: str, metadata: dict[str, str], pieces: "Iterator[SurfaceTable]"
) -> int:
    """Write all of it, or no session; returns how many rows."""
    from vsensor.recording.writer import all_or_nothing

    with all_or_nothing(output, configuration=configuration, metadata=metadata, compression="zstd") as writer:
        return _write(writer, pieces)


def _write(writer: "SessionWriter", pieces: "Iterator[SurfaceTable]") -> int:
    from vsensor.tables import SurfaceSamples

    rows, samples = 0, SurfaceSamples()
    for table in pieces:
        for topic, sample in samples.of(table):
            writer.write(topic, sample.SerializeToString(), sample.time_ns, sample.time_ns, sample.sequence)
        rows += len(table)
    return rows
