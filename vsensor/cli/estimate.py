"""`vsensor estimate`: the same estimator over a file, as fast as it goes."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer
from rich.console import Console

from vsensor.cli.options import NULL
from vsensor.cli.reading import reading
from vsensor.config import Rig, load, loads
from vsensor.errors import ConfigError, InputError

if TYPE_CHECKING:
    from vsensor.intake.arrivals import Feed
    from vsensor.messages import Event, Sample
    from vsensor.offline import Offline
    from vsensor.recording.reader import Session
    from vsensor.service.engine import Engine


def estimate(
    source: Annotated[
        Path, typer.Argument(metavar="INPUT", help="Samples: .mcap, .csv, .parquet, .feather or .npz.")
    ],
    config: Annotated[
        Path | None, typer.Argument(help="The rig; for a session, by default, the one recorded in it.")
    ] = None,
    *,
    output: Annotated[Path, typer.Option("-o", "--output", help="Estimates: .csv, .parquet, .npz or .mcap.")],
    forecast: Annotated[
        bool,
        typer.Option(
            "--forecast/--no-forecast",
            help="Without, the forecast is left out, which takes 0.75 of the time; all else stays the same.",
        ),
    ] = True,
    null: Annotated[list[float], NULL] = [],  # noqa: B006, typer copies it
) -> None:
    """Estimate the bit from recorded surface samples."""
    from vsensor.tables import check_writable
    from vsensor.tables.sinks import SINKS

    if output.suffix not in SINKS and output.suffix != ".mcap":
        raise ConfigError(f"{output}: estimates go into {', '.join(SINKS)} or .mcap: end its name so")
    if output.exists() and source.exists() and output.samefile(source):
        raise ConfigError(f"{output}: is what is read: choose another name for the estimates")
    read, rig = _opened(source, config, tuple(null))
    write = _to_session if output.suffix == ".mcap" else _to_table
    if write is _to_table:
        check_writable(output)  # before the work, not after
    console = Console(highlight=False, markup=False, soft_wrap=True)
    with reading(source, "estimating", console):
        ticks = write(rig, read, output, forecast, console)
    if not isinstance(read, Table) and (shortfall := read.shortfall()):
        typer.echo(f"{source} {shortfall}; what is left of it is estimated", err=True)
    console.print(f"{ticks} ticks estimated into {output}")


class Table(NamedTuple):
    """A table to be read, and the numbers in it that stand for none."""

    path: Path
    nulls: tuple[float, ...]


def _opened(source: Path, config: Path | None, nulls: tuple[float, ...]) -> "tuple[Table | Session, Rig]":
    """The table, or the session opened; and the rig."""
    from vsensor.recording.reader import Session
    from vsensor.tables.sources import source_of

    rig = load(config) if config is not None else None
    if not _is_session(source):
        if rig is None:
            source_of(source)  # refuses what is none
            raise ConfigError(
                f"{source}: a table holds no configuration: name one, as in\n"
                f"  vsensor estimate {source} RIG.toml -o OUTPUT"
            )
        return Table(source, nulls), rig
    if nulls:
        raise ConfigError(f"{source}: is a session: --null is for a table")
    session = Session(source)
    if rig is None and session.configuration is None:
        raise ConfigError(str(session.lacks("holds no configuration: name one behind it")))
    return session, rig or loads(session.configuration or "", f"{source}: recorded configuration")


def _is_session(source: Path) -> bool:
    """Whole or torn: NAME.mcap, NAME.mcap.part."""
    return ".mcap" in (suffix.lower() for suffix in source.suffixes)


def _feed(source: "Table | Session", forecast: bool, sensor: "Offline | None" = None) -> "Feed":
    """Samples by columns and, of a session, what else the sensor was told between them.

    Depths that change nothing for a `sensor` are given to it at once. Where no forecast is wanted, nothing
    tells of when there was time for one.
    """
    from vsensor.intake import FORECAST_SHED, OBEYED
    from vsensor.intake.arrivals import Arrivals
    from vsensor.recording.feed import feed
    from vsensor.tables import Findings, Layout, surface_pieces

    if not isinstance(source, Table):
        settling = (sensor.intake.depths.settles,) if sensor else ()
        obeyed = [name for name in OBEYED if forecast or name != FORECAST_SHED]
        yield from feed(source, obeyed, *settling)
        return
    torque, speed, findings = 0, 0, Findings()
    for table in surface_pieces(source.path, Layout(nulls=source.nulls), as_it_came=True, findings=findings):
        first = torque, speed
        yield Arrivals.in_turn(table.time_ns, table.motor_torque_nm, table.motor_speed_rad_s, first)
        torque, speed = torque + table.samples[0], speed + table.samples[1]
    for line in findings.words():
        typer.echo(f"{source.path}: {line}", err=True)


def _samples(source: "Table | Session", forecast: bool) -> "Iterator[tuple[str, Sample | Event]]":
    """The same one by one."""
    from vsensor.intake.arrivals import Arrivals

    for come in _feed(source, forecast):
        if isinstance(come, Arrivals):
            yield from come.samples()
        else:
            yield come


def _begin(source: "Table | Session", engine: "Engine | Offline", forecast: bool, console: Console) -> None:
    """Let a later part of a recording go on from what the sensor remembered at its start."""
    if not isinstance(source, Table):
        _take_up(source, engine, console)
    engine.intake.forecast_shed |= not forecast


def _take_up(session: "Session", engine: "Engine | Offline", console: Console) -> None:
    state = session.state()
    if state is None:
        return
    try:
        engine.take_up(state)
    except ValueError as error:
        console.print(f"{session.path}: what the sensor remembered at the start is left aside: {error}")


def _to_table(rig: Rig, source: "Table | Session", output: Path, forecast: bool, console: Console) -> int:
    from vsensor.offline import Offline
    from vsensor.tables import ESTIMATE_FIELDS, TableWriter

    sensor = Offline(rig)
    _begin(source, sensor, forecast, console)
    with TableWriter(output, tuple(ESTIMATE_FIELDS)) as writer:
        for columns in sensor.estimates(_feed(source, forecast, sensor)):
            writer.write(columns)
        _tell_refused(sensor, rig, console)
        if writer.rows == 0:
            raise _no_tick(source)
    return writer.rows


def _to_session(rig: Rig, source: "Table | Session", output: Path, forecast: bool, console: Console) -> int:
    from vsensor import checkpoint
    from vsensor.config import effective_toml
    from vsensor.messages import BIT_ESTIMATE, SENSOR_STATE, SENSOR_TICK
    from vsensor.provenance import provenance
    from vsensor.recording.writer import all_or_nothing
    from vsensor.service.engine import Engine

    engine = Engine(rig)
    _begin(source, engine, forecast, console)
    begun = checkpoint.whole(*checkpoint.remembered(engine.intake, engine.estimator))
    ticks = 0
    with all_or_nothing(
        output,
        configuration=effective_toml(rig),
        metadata=provenance(rig),
        compression=rig.recording.compression,
    ) as writer:
        writer.write(SENSOR_STATE, begun.SerializeToString(), begun.time_ns, begun.time_ns)
        for topic, sample in _samples(source, forecast):
            writer.write(topic, sample.SerializeToString(), sample.time_ns, sample.time_ns)
            for tick, told in engine.take(topic, sample):
                writer.write(SENSOR_TICK, tick.SerializeToString(), tick.time_ns, tick.time_ns)
                writer.write(BIT_ESTIMATE, told.SerializeToString(), tick.time_ns, tick.time_ns)
                ticks += 1
        _tell_refused(engine, rig, console)
        if ticks == 0:
            raise _no_tick(source)
    return ticks


def _tell_refused(sensor: "Engine | Offline", rig: Rig, console: Console) -> None:
    """Say what was not used; where it was most of a channel, what is likely the matter."""
    from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE
    from vsensor.messages.books import refused, words

    most = {
        SURFACE_TORQUE: f"{rig.measurement.torque_limit:g} N·m",
        SURFACE_SPEED: f"{rig.measurement.speed_limit:g} rad/s",
    }
    for topic, channel in sensor.intake.channels.items():
        counts = channel.counts
        if refused(counts):
            said = f"{refused(counts)} of {counts.received} samples of {topic} were refused: {words(counts)}"
            wrong = counts.out_of_range > counts.accepted
            console.print(f"{said}; at most {most[topic]} is believed: is the unit right?" if wrong else said)


def _no_tick(source: "Table | Session") -> InputError:
    what = "gives no tick: both surface channels are needed, from one time on"
    return InputError(f"{source.path}: {what}") if isinstance(source, Table) else source.lacks(what)
