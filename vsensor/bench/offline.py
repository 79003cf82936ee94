"""An hour of samples through the sensor without a clock, and where the time goes."""

import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from vsensor.bench.record import endless
from vsensor.bench.table import Table
from vsensor.config import Rig, load
from vsensor.demo import example
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import NO_FORECAST
from vsensor.intake import Intake
from vsensor.intake.arrivals import Arrivals
from vsensor.intake.stretch import laid
from vsensor.messages import Sample
from vsensor.offline import Offline
from vsensor.tables import SurfaceTable, write_estimates

SPEED_UP = 720
"""Seconds of samples for each second asked for: five make an hour."""
CHUNK = 2000
"""Ticks for which each stage is timed before the next has its turn."""

P = ParamSpec("P")
R = TypeVar("R")
Columns = Mapping[str, NDArray[np.generic]]


class Stages:
    """Seconds spent by stage, one entry a chunk."""

    def __init__(self) -> None:
        self._seconds: defaultdict[str, list[float]] = defaultdict(list)

    def timed(self, stage: str, work: Callable[P, R], *given: P.args, **named: P.kwargs) -> R:
        """Do a stage's work, and count its time."""
        begun = time.perf_counter()
        done = work(*given, **named)
        self._seconds[stage].append(time.perf_counter() - begun)
        return done

    def whole(self, stage: str) -> float:
        """Seconds for all chunks, taken from the middle one: a disturbance in a few does not count."""
        seconds = self._seconds[stage]
        return float(np.median(seconds)) * len(seconds)


def tables(seconds: float) -> Iterator[Table]:
    """Run `seconds` · 720 s of simulated samples of the example rig as `vsensor estimate` does."""
    rig = load(example("drilling.toml"))
    surface = surface_table(rig, max(1, round(seconds * SPEED_UP * rig.loop.rate)))
    stages = Stages()
    ticks, accepted, columns = _run(rig, surface, stages)
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as folder:
        for kind in ("csv", "parquet"):
            stages.timed(kind, write_estimates, Path(folder) / f"estimates.{kind}", columns)
    length = len(surface.time_s) / rig.loop.rate
    spent = _spent(stages)
    yield Table(
        f"Offline: {length:.0f} s of samples at {rig.loop.rate:g} Hz, as fast as it goes",
        ("stage", "seconds", "µs a tick", "times the estimator"),
        tuple(
            (stage, took, took / ticks * 1e6, took / spent["estimator alone"])
            for stage, took in spent.items()
        ),
        (
            f"{len(surface.time_s)} rows gave {accepted} samples accepted and {ticks} ticks",
            "the yardstick is the compiled estimator alone, over arrays in memory; the rest is what Offline "
            "takes beside intake and estimator; sample by sample is what the daemon does",
            f"all but the first run {length / spent['all but the first']:.0f} times faster than life",
        ),
    )


def _spent(stages: Stages) -> dict[str, float]:
    rows, one_by_one, intake, estimator, offline = map(
        stages.whole, ("rows", "one by one", "intake", "estimator", "offline")
    )
    return {
        "intake, sample by sample": one_by_one,
        "rows to columns of samples": rows,
        "intake by columns": intake,
        "estimator alone": estimator,
        "the same, no forecast": stages.whole("no forecast"),
        "the rest: table, verdicts": max(0.0, offline - intake - estimator),
        "all but the first": rows + offline,
        "writing CSV": stages.whole("csv"),
        "writing Parquet": stages.whole("parquet"),
    }


def surface_table(rig: Rig, rows: int) -> SurfaceTable:
    """Surface samples of a simulated rig: a rig takes longer to simulate than to sense, so over and over."""
    torque, speed = (np.resize(once, rows) for once in endless(rig))
    return SurfaceTable.at_seconds(np.arange(rows) / rig.loop.rate, torque, speed)


def _run(rig: Rig, surface: SurfaceTable, stages: Stages) -> tuple[int, int, Columns]:
    """Chunk by chunk: the samples, each stage alone, then all of `Offline` on the same samples."""
    intake, slow, offline = Intake(rig), Intake(rig), Offline(rig)
    estimator, short = Estimator(rig), Estimator(rig)
    done: list[Columns] = []
    for start in range(0, len(surface), CHUNK):
        samples = stages.timed("rows", _arrivals, surface, start)
        ticks = stages.timed("intake", list, laid(intake, samples))
        stages.timed("one by one", _one_by_one, slow, list(samples.samples()))
        for given in ticks:
            inputs = given.motor_torque, given.motor_speed
            stages.timed("estimator", estimator.run, *inputs)
            stages.timed("no forecast", short.run, *inputs, np.full(len(given.number), NO_FORECAST))
        done += stages.timed("offline", list, offline.estimates([samples]))
    columns = {name: np.concatenate([chunk[name] for chunk in done]) for name in done[0]}
    accepted = sum(channel.counts.accepted for channel in offline.intake.channels.values())
    return len(columns["time_s"]), accepted, columns


def _arrivals(surface: SurfaceTable, start: int) -> Arrivals:
    rows = slice(start, start + CHUNK)
    return Arrivals.in_turn(
        surface.time_ns[rows],
        surface.motor_torque_nm[rows],
        surface.motor_speed_rad_s[rows],
        (start, start),
    )


def _one_by_one(intake: Intake, samples: list[tuple[str, Sample]]) -> None:
    for topic, sample in samples:
        intake.take(topic, sample)
