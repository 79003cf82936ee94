"""The sensor at work at each rate: is anything lost, how late does it wake, what does it cost."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from vsensor.bench.compiler import NO_COMPILER, compiler
from vsensor.bench.stage import START_S, Run, run
from vsensor.bench.table import Cell, Table
from vsensor.bench.wakes import Wakes, bare_loop, build_bare_loop
from vsensor.config import Rig, effective_toml, load, loads
from vsensor.demo import example
from vsensor.messages import BIT_ESTIMATE, SURFACE_SPEED, SURFACE_TORQUE

LEAST_S = 3.0
"""A shorter run would be all start."""


def tables(seconds: float, rates_hz: Sequence[float], say: Callable[[str], None]) -> Iterator[Table]:
    """Run the demonstration's rig for `seconds`, at least 3, at each rate; `say` hears what is going on.

    Raises ConfigError for an impossible rate, VsensorError where a process fails.
    """
    length = max(seconds, LEAST_S)
    rigs = [rig_at(rate) for rate in rates_hz]
    runs: list[Run] = []
    alone: list[Wakes | None] = []
    cc = compiler()
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as name:
        bare = build_bare_loop(cc, Path(name)) if cc else None
        for rig in rigs:
            rate = rig.loop.rate
            if bare:
                say(f"a bare loop in C at {rate:g} Hz for {length:g} s")
                with bare_loop(bare, rate, length) as wakes:
                    alone.append(wakes())
            else:
                alone.append(None)
            say(f"rig, daemon and recorder at {rate:g} Hz for {length + START_S:g} s")
            runs.append(run(rig, Path(tempfile.mkdtemp(dir=name)), length, bare))
    yield _books(runs)
    yield _lateness(runs, alone)
    yield _cost(runs)


def rig_at(rate: float) -> Rig:
    """The demonstration's rig at another rate. Raises ConfigError where that is impossible."""
    rig = load(example("drilling.toml"))
    changed = rig.model_copy(update={"loop": rig.loop.model_copy(update={"rate": rate})})
    return loads(effective_toml(changed), f"--rate {rate:g}")


def _books(runs: Sequence[Run]) -> Table:
    books = [book(run) for run in runs]
    return Table(
        "Live: what the rig sent, and what became of it",
        ("count", *(f"at {run.rate_hz:g} Hz" for run in runs)),
        tuple((what, *(book[what] for book in books)) for what in books[0]),
        ("published by the rig's own count, all else by the session's; two samples make a tick",),
    )


def book(run: Run) -> dict[str, int | None]:
    """What was sent, and what became of it: where all is well, the samples agree, and the ticks."""
    recorded = {topic.topic: topic.messages for topic in run.summary.topics}
    surface = recorded.get(SURFACE_TORQUE, 0) + recorded.get(SURFACE_SPEED, 0)
    consumed = sum(channel.accepted for channel in run.status.channels)
    return {
        "samples published": run.published,
        "samples consumed": consumed,
        "samples recorded": surface,
        "samples lost": run.published - min(consumed, surface),
        "ticks due": run.published // 2,
        "ticks run": run.status.ticks,
        "estimates recorded": recorded.get(BIT_ESTIMATE, 0),
        "messages not recorded": run.summary.dropped,
        "slots of the loop due": run.status.slots_due,
        "slots of the loop skipped": run.status.slots_skipped,
    }


def _lateness(runs: Sequence[Run], alone: Sequence[Wakes | None]) -> Table:
    return Table(
        "Live: how late each turn wakes",
        (
            "loop",
            "median, µs",
            "99 %, µs",
            "worst, µs",
            "missed, ‰",
            "ratio, median",
            "ratio, 99 %",
        ),
        tuple(row for pair in zip(runs, alone, strict=True) for row in _lateness_rows(*pair)),
        (
            "C: a bare loop that sleeps to the same grid (clock_nanosleep) and does nothing else, at the "
            "same time and before; ratio: the daemon's over this one's; missed: slots passed while the turn "
            "before had not ended; no loop here has real-time priority"
            if any(alone)
            else NO_COMPILER,
        ),
    )


def _lateness_rows(run: Run, alone: Wakes | None) -> Iterator[tuple[Cell, ...]]:
    loops = {"daemon": run.daemon, "C, beside it": run.beside, "C, alone": alone}
    for loop, wakes in loops.items():
        if wakes is not None:
            ratios = (run.daemon.percentile_us(share) / wakes.percentile_us(share) for share in (50, 99))
            yield (
                f"{run.rate_hz:g} Hz, {loop}",
                *(wakes.percentile_us(share) for share in (50, 99, 100)),
                1000 * wakes.skipped / wakes.due,
                *(None if loop == "daemon" else ratio for ratio in ratios),
            )


def _cost(runs: Sequence[Run]) -> Table:
    return Table(
        "Live: processor time while the rig published",
        ("rate, Hz", "process", "of one core, %", "µs a tick"),
        tuple(
            (run.rate_hz, name, 100 * took / run.processor.wall, took / run.status.ticks * 1e6)
            for run in runs
            for name, took in (("daemon", run.processor.daemon), ("recorder", run.processor.recorder))
        ),
        ("the yardstick is one core; the kernel's share is in it",),
    )
