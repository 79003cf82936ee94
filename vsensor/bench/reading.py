"""Sessions read by columns beside the mcap library's own reader, and what each compression costs."""

import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from vsensor.bench.rounds import Times, alternate
from vsensor.bench.sessions import recorded, write
from vsensor.bench.table import Cell, Table
from vsensor.config import load
from vsensor.demo import example
from vsensor.errors import VsensorError
from vsensor.messages import BIT_ESTIMATE, SURFACE_SPEED, SURFACE_TORQUE, Estimate
from vsensor.recording.columns import read_columns
from vsensor.recording.reader import Session
from vsensor.recording.writer import Compression

SPEED_UP = 48
"""Seconds of session for each second asked for,"""
LONGEST_S = 240.0
"""but no more than so many: the library takes a second for each two minutes, over and over."""
SIMULATED_S = 20.0
"""So much is simulated, then repeated: a rig takes longer to simulate than to record."""
COMPRESSIONS: tuple[Compression, ...] = ("none", "lz4", "zstd")
DAY_S = 86_400.0

Wanted = Mapping[str, Sequence[str]]
WANTED: Mapping[str, Wanted] = {
    "surface samples": dict.fromkeys((SURFACE_TORQUE, SURFACE_SPEED), ("time_ns", "value", "sequence")),
    "estimates, every field": {BIT_ESTIMATE: [field.name for field in Estimate.DESCRIPTOR.fields]},
}


_Read = dict[tuple[str, str], tuple[int, dict[str, Times]]]
"""By compression and what is wanted: how many messages, and how long our reader and the library's take."""


class _Case(NamedTuple):
    """A session in one compression: where it is, how many ticks it has, and how long each message took, s."""

    path: Path
    ticks: int
    taken: np.ndarray


def tables(seconds: float) -> Iterator[Table]:
    """Write and read sessions of up to four minutes in each compression. VsensorError where ours errs."""
    rig = load(example("drilling.toml"))
    told = recorded(rig, SIMULATED_S)
    times = max(1, round(min(seconds * SPEED_UP, LONGEST_S) / SIMULATED_S))
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as folder:
        cases: dict[str, _Case] = {}
        for compression in COMPRESSIONS:
            path = Path(folder) / f"{compression}.mcap"
            taken = write(path, rig, told, times, compression)
            ticks = times * sum(topic == BIT_ESTIMATE for topic, *_ in told)
            cases[compression] = _Case(path, ticks, taken)
        read: _Read = {
            (compression, what): _read(case.path, wanted, seconds / len(COMPRESSIONS) / len(WANTED))
            for compression, case in cases.items()
            for what, wanted in WANTED.items()
        }
        yield _reading(read)
        yield _compressions(cases, read, rig.loop.rate)


def _read(path: Path, wanted: Wanted, seconds: float) -> tuple[int, dict[str, Times]]:
    """How many messages there are, and how long both readers take to make columns of them."""
    works = {"columns": partial(by_columns, path, wanted), "library": partial(by_library, path, wanted)}
    ours, theirs = (work() for work in works.values())
    for (topic, name), column in ours.items():
        if column.tobytes() != theirs[topic, name].astype(column.dtype).tobytes():
            raise VsensorError(f"{path.name}: {name} of {topic} is not what the mcap library reads")
    count = sum(len(ours[topic, fields[0]]) for topic, fields in wanted.items())
    return count, alternate(works, seconds, time.process_time_ns)


def by_columns(path: Path, wanted: Wanted) -> dict[tuple[str, str], np.ndarray]:
    """Each field of each topic wanted, by our reader."""
    parts: dict[tuple[str, str], list[np.ndarray]] = {}
    for piece in read_columns(Session(path), wanted):
        for topic, columns in piece.items():
            for name in wanted[topic]:
                parts.setdefault((topic, name), []).append(columns.values[name])
    return {key: np.concatenate(values) for key, values in parts.items()}


def by_library(path: Path, wanted: Wanted) -> dict[tuple[str, str], np.ndarray]:
    """The same by the mcap library's own reader, message by message in the file's order."""
    columns: dict[tuple[str, str], list[float]] = {
        (topic, name): [] for topic, names in wanted.items() for name in names
    }
    with path.open("rb") as file:
        decoders = [DecoderFactory()]
        reader = make_reader(file, decoder_factories=decoders)
        for _, channel, _, message in reader.iter_decoded_messages(topics=list(wanted), log_time_order=False):
            for name in wanted[channel.topic]:
                columns[channel.topic, name].append(getattr(message, name))
    return {key: np.array(values) for key, values in columns.items()}


def _reading(read: _Read) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for (compression, what), (count, taken) in read.items():
        ours, theirs = (taken[name].median / count / 1e3 for name in ("columns", "library"))
        rows.append((what, compression, count, ours, theirs, theirs / ours))
    return Table(
        "A session read: by columns, and by the mcap library's own reader",
        ("what", "compression", "messages", "by columns, µs", "by the library, µs", "times faster"),
        tuple(rows),
        (
            "µs of the processor a message, from the file to arrays of the fields, the same to the bit",
            "the sessions hold all that a daemon records, and all of it is unpacked, whatever is asked for",
        ),
    )


def _compressions(cases: Mapping[str, _Case], read: _Read, rate: float) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for compression, (path, ticks, taken) in cases.items():
        size = path.stat().st_size / ticks
        _, of_estimates = (read[compression, what][1] for what in WANTED)
        rows.append(
            (
                compression,
                size,
                size * rate * DAY_S / 1e9,
                float(taken.sum()) / ticks * 1e6,
                float(np.sort(taken)[-len(taken) // 1000 :].mean()) * 1e3,
                float(taken.max()) * 1e3,
                of_estimates["columns"].median / ticks / 1e3,
            )
        )
    return Table(
        "What a compression costs, a tick with all that is recorded of it",
        (
            "compression",
            "bytes a tick",
            f"GB a day at {rate:g} Hz",
            "writing, µs a tick",
            "longest of 1000 writes, ms",
            "longest stall, ms",
            "reading, µs a tick",
        ),
        tuple(rows),
        (
            "writing is what the recorder's process does, not the loop's; it syncs each second, "
            "and a stall is one message that had to wait for that or for its chunk to be packed",
            "reading: the estimates by columns",
        ),
    )
