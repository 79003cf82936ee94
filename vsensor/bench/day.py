"""A day of surface samples, from the session to a table: processor time and memory of whole commands.

A day is told from two sessions, for a command has its start besides: from the one to the other it takes so
much more, and so on to the day.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from vsensor.bench.offline import SPEED_UP, surface_table
from vsensor.bench.reading import DAY_S, by_library
from vsensor.bench.table import Table
from vsensor.config import Rig, effective_toml, load
from vsensor.demo import example
from vsensor.errors import VsensorError
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE
from vsensor.recording.writer import SessionWriter
from vsensor.tables import SurfaceSamples

PART = 4
"""The shorter session is so much shorter."""
ASKED = "asked of a day, estimated anew: 30 s on one core, 600 MB"
TURNS = 3
COMMANDS = {
    "samples to Parquet": ("export", "--surface"),
    "estimated anew to Parquet": ("estimate",),
    "the same, no forecast": ("estimate", "--no-forecast"),
}


class Spent(NamedTuple):
    """What a command took."""

    processor_s: float
    resident_bytes: int
    """At most."""


def tables(seconds: float, say: Callable[[str], None]) -> Iterator[Table]:
    """Run each command on sessions of `seconds` · 720 s and a quarter of it. VsensorError where one fails."""
    rig = load(example("drilling.toml"))
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as name:
        say("two sessions are written")
        rows = max(PART, round(seconds * SPEED_UP * rig.loop.rate))
        sessions = {length: _session(Path(name), rig, length) for length in (rows // PART, rows)}
        yield _table(sessions, rig.loop.rate, say)


def _session(folder: Path, rig: Rig, rows: int) -> Path:
    path, samples = folder / f"{rows}.mcap", SurfaceSamples()
    about = {"rig": rig.rig.name}
    with SessionWriter(
        path, configuration=effective_toml(rig), metadata=about, compression=rig.recording.compression
    ) as writer:
        for topic, sample in samples.of(surface_table(rig, rows)):
            writer.write(topic, sample.SerializeToString(), sample.time_ns, sample.time_ns, sample.sequence)
    return path


def _table(sessions: dict[int, Path], rate: float, say: Callable[[str], None]) -> Table:
    (few, short), (rows, long) = sessions.items()
    say("the mcap library's own reader")
    begun = time.process_time()
    by_library(short, dict.fromkeys((SURFACE_TORQUE, SURFACE_SPEED), ("time_ns", "value")))
    library_s = (time.process_time() - begun) * rate * DAY_S / few
    told = []
    for name, (command, *options) in COMMANDS.items():
        say(name)
        one, other = _least((command, str(path), "-o", f"{path}.parquet", *options) for path in (short, long))
        per_row_s = (other.processor_s - one.processor_s) / (rows - few)
        day_s = other.processor_s + per_row_s * (rate * DAY_S - rows)
        told.append(
            (name, one.processor_s, other.processor_s, other.resident_bytes / 1e6, day_s, library_s / day_s)
        )
    return Table(
        f"A day at {rate:g} Hz, from the session to a table",
        (
            *("command", f"{few / rate:.0f} s, s", f"{rows / rate:.0f} s, s", "memory at most, MB"),
            *("a day, s", "times faster than the library reads"),
        ),
        tuple(told),
        (
            f"the mcap library alone, message by message, not estimating: {library_s:.0f} s for a day",
            f"seconds of the processor, of the whole command, the least of {TURNS} turns",
            "the day: by what the longer session takes more",
            ASKED,
        ),
    )


def _least(commands: Iterable[Sequence[str]]) -> list[Spent]:
    """What each takes when nothing disturbs it: the least of some turns, the first of which may compile."""
    commands = list(commands)
    turns = [[_run(words) for words in commands] for _ in range(TURNS)]
    return [
        Spent(min(s for s, _ in each), max(held for _, held in each)) for each in zip(*turns, strict=True)
    ]


def _run(words: Sequence[str]) -> Spent:
    with subprocess.Popen(
        [sys.executable, "-m", "vsensor.cli.main", *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as running:
        complaint = running.stderr.read() if running.stderr else ""
        _, status, used = os.wait4(running.pid, 0)
        running.returncode = os.waitstatus_to_exitcode(status)
    if running.returncode:
        raise VsensorError(f"vsensor {' '.join(words)} ended with {running.returncode}: {complaint}")
    return Spent(used.ru_utime + used.ru_stime, used.ru_maxrss * 1024)
