"""`vsensor estimate`: the same estimator over a file, as fast as it goes."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    from vsensor.service.engine import Engine

Nulls = tuple[float, ...]


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
    if null and _is_session(source):
        raise ConfigError(f"{source}: is a session: --null is for a table")
    rig = _rig(source, config)
    write = _to_session if output.suffix == ".mcap" else _to_table
    if write is _to_table:
        check_writable(output)  # before the work, not after
    console = Console(highlight=False, markup=False, soft_wrap=True)
    with reading(source, "estimating", console):
        ticks = write(rig, source, output, forecast, tuple(null), console)
    console.print(f"{ticks} ticks estimated into {output}")


def _rig(source: Path, config: Path | None) -> Rig:
    if config is not None:
        return load(config)
    from vsensor.tables.sources import source_of

    if not _is_session(source):
        source_of(source)  # refuses what is none
        raise ConfigError(
            f"{source}: a table holds no configuration: name one, as in\n"
            f"  vsensor estimate {source} RIG.toml -o OUTPUT"
        )
    from vsensor.recording.reader import Session

    recorded = Session(source).configuration
    if recorded is None:
        raise ConfigError(f"{source}: holds no configuration: name one behind it")
    return loads(recorded, f"{source}: recorded configuration")


def _is_session(source: Path) -> bool:
    """Whole or torn: NAME.mcap, NAME.mcap.part."""
    return ".mcap" in (suffix.lower() for suffix in source.suffixes)


def _feed(source: Path, forecast: bool, nulls: Nulls, sensor: "Offline | None" = None) -> "Feed":
    """Samples by columns and, of a session, what else the sensor was told between them.

    Depths that change nothing for a `sensor` are given to it at once. Where no forecast is wanted, nothing
    tells of when there was time for one. What looks odd in a table goes to standard error.
    """
    from vsensor.intake import FORECAST_SHED, OBEYED
    from vsensor.intake.arrivals import Arrivals
    from vsensor.recording.feed import feed
    from vsensor.recording.reader import Session
    from vsensor.tables import Findings, Layout, surface_pieces

    if _is_session(source):
        settling = (sensor.intake.depths.settles,) if sensor else ()
        obeyed = [name for name in OBEYED if forecast or name != FORECAST_SHED]
        yield from feed(Session(source), obeyed, *settling)
        return
    torque, speed, findings = 0, 0, Findings()
    for table in surface_pieces(source, Layout(nulls=nulls), as_it_came=True, findings=findings):
        first = torque, speed
        yield Arrivals.in_turn(table.time_ns, table.motor_torque_nm, table.motor_speed_rad_s, first)
        torque, speed = torque + table.samples[0], speed + table.samples[1]
    for line in findings.words():
        typer.echo(f"{source}: {line}", err=True)


def _samples(source: Path, forecast: bool, nulls: Nulls) -> "Iterator[tuple[str, Sample | Event]]":
    """The same one by one."""
    from vsensor.intake.arrivals import Arrivals

    for come in _feed(source, forecast, nulls):
        if isinstance(come, Arrivals):
            yield from come.samples()
        else:
            yield come


def _begin(source: Path, engine: "Engine | Offline", forecast: bool, console: Console) -> None:
    """Let a later part of a recording go on from what the sensor remembered at its start."""
    _take_up(source, engine, console)
    engine.intake.forecast_shed |= not forecast


def _take_up(source: Path, engine: "Engine | Offline", console: Console) -> None:
    from vsensor.recording.reader import Session

    state = Session(source).state() if _is_session(source) else None
    if state is None:
        return
    try:
        engine.take_up(state)
    except ValueError as error:
        console.print(f"{source}: what the sensor remembered at the start is left aside: {error}")


def _to_table(rig: Rig, source: Path, output: Path, forecast: bool, nulls: Nulls, console: Console) -> int:
    from vsensor.offline import Offline
    from vsensor.tables import ESTIMATE_FIELDS, TableWriter

    sensor = Offline(rig)
    _begin(source, sensor, forecast, console)
    with TableWriter(output, tuple(ESTIMATE_FIELDS)) as writer:
        for columns in sensor.estimates(_feed(source, forecast, nulls, sensor)):
            writer.write(columns)
        _tell_refused(sensor, rig, console)
        if writer.rows == 0:
            raise _no_tick(source)
    return writer.rows


def _to_session(rig: Rig, source: Path, output: Path, forecast: bool, nulls: Nulls, console: Console) -> int:
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
        for topic, sample in _samples(source, forecast, nulls):
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


def _no_tick(source: Path) -> InputError:
    return InputError(f"{source}: no tick came of it: both surface channels are needed, from one time on")
