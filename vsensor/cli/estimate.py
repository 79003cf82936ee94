"""`vsensor estimate`: the same estimator over a file, as fast as it goes."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape

from vsensor.config import Rig, load, loads
from vsensor.errors import ConfigError, InputError

if TYPE_CHECKING:
    from vsensor.messages import Event, Sample
    from vsensor.offline import Offline
    from vsensor.service.engine import Engine


def estimate(
    source: Annotated[Path, typer.Argument(metavar="INPUT", help="Samples: .mcap, .csv or .parquet.")],
    config: Annotated[
        Path | None, typer.Argument(help="The rig; for a session, by default, the one recorded in it.")
    ] = None,
    *,
    output: Annotated[Path, typer.Option("-o", "--output", help="Estimates: .csv, .parquet or .mcap.")],
) -> None:
    """Estimate the bit from recorded surface samples."""
    from vsensor.tables import is_csv

    rig = _rig(source, config)
    write = _to_session if output.suffix == ".mcap" else _to_table
    if write is _to_table:
        is_csv(output)  # before the work, not after
    console = Console()
    with console.status(f"estimating {source}"):
        ticks = write(rig, source, output, console)
    if ticks == 0:
        raise InputError(f"{source}: no tick came of it: both surface channels are needed, from one time on")
    console.print(f"{ticks} ticks estimated into {output}", soft_wrap=True, highlight=False)


def _rig(source: Path, config: Path | None) -> Rig:
    if config is not None:
        return load(config)
    if source.suffix != ".mcap":
        raise ConfigError(
            f"{source}: a table holds no configuration: name one, as in\n"
            f"  vsensor estimate {source} RIG.toml -o OUTPUT"
        )
    from vsensor.recording.reader import Session

    recorded = Session(source).configuration
    if recorded is None:
        raise ConfigError(f"{source}: holds no configuration: name one behind it")
    return loads(recorded, f"{source}: recorded configuration")


def _samples(source: Path) -> "Iterator[tuple[str, Sample | Event]]":
    """Samples and, of a session, what the sensor was told between them."""
    from vsensor.commands import COMMAND
    from vsensor.messages import SENSOR_EVENT, SURFACE_TOPICS, Event, Sample
    from vsensor.recording.reader import Session
    from vsensor.tables import read_surface, surface_samples

    if source.suffix != ".mcap":
        yield from surface_samples(read_surface(source))
        return
    for topic, message, _, _ in Session(source).messages((*SURFACE_TOPICS, SENSOR_EVENT)):
        if isinstance(message, Sample) or (isinstance(message, Event) and message.name == COMMAND):
            yield topic, message


def _begun(source: Path, engine: "Engine | Offline", console: Console) -> None:
    """A later part of a recording goes on from what the sensor remembered at its start."""
    from vsensor.recording.reader import Session

    state = Session(source).state() if source.suffix == ".mcap" else None
    if state is None:
        return
    try:
        engine.take_up(state)
    except ValueError as error:
        console.print(
            f"what the recording sensor remembered at the start is left aside: {escape(str(error))}",
            soft_wrap=True,
            highlight=False,
        )


def _to_table(rig: Rig, source: Path, output: Path, console: Console) -> int:
    import numpy as np

    from vsensor.offline import Offline
    from vsensor.tables import write_estimates

    sensor = Offline(rig)
    _begun(source, sensor, console)
    chunks = list(sensor.estimates(_samples(source)))
    if not chunks:
        return 0
    columns = {name: np.concatenate([chunk[name] for chunk in chunks]) for name in chunks[0]}
    write_estimates(output, columns)
    return len(columns["time_s"])


def _to_session(rig: Rig, source: Path, output: Path, console: Console) -> int:
    from vsensor import checkpoint
    from vsensor.config import effective_toml
    from vsensor.messages import BIT_ESTIMATE, SENSOR_STATE, SENSOR_TICK
    from vsensor.provenance import provenance
    from vsensor.recording.writer import SessionWriter
    from vsensor.service.engine import Engine

    engine = Engine(rig)
    _begun(source, engine, console)
    begun = checkpoint.whole(*checkpoint.remembered(engine.intake, engine.estimator))
    ticks = 0
    with SessionWriter(
        output,
        configuration=effective_toml(rig),
        metadata=provenance(rig),
        compression=rig.recording.compression,
    ) as writer:
        writer.write(SENSOR_STATE, begun.SerializeToString(), begun.time_ns, begun.time_ns)
        for topic, sample in _samples(source):
            writer.write(topic, sample.SerializeToString(), sample.time_ns, sample.time_ns)
            for tick, told in engine.take(topic, sample):
                writer.write(SENSOR_TICK, tick.SerializeToString(), tick.time_ns, tick.time_ns)
                writer.write(BIT_ESTIMATE, told.SerializeToString(), tick.time_ns, tick.time_ns)
                ticks += 1
    return ticks
