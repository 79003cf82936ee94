"""The sensor on time under load, beside its yardsticks: lateness, latency, and what it takes."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from vsensor.bench.compiler import NO_COMPILER, compiler
from vsensor.bench.live import rig_at
from vsensor.bench.table import Cell, Table
from vsensor.bench.turns import LOADS, TURN_S, Measured, under_loads
from vsensor.bench.wakes import build_bare_loop


def tables(rates_hz: Sequence[float], seconds: float, say: Callable[[str], None]) -> Iterator[Table]:
    """Run the demonstration's daemon at each rate and under each load, with real-time priority if granted.

    Raises VsensorError where a process fails.
    """
    rigs = [rig_at(rate) for rate in rates_hz]
    cc = compiler()
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as name:
        bare = build_bare_loop(cc, Path(name)) if cc else None
        measured = [one for rig in rigs for one in under_loads(rig, Path(name), bare, seconds, say, LOADS)]
    yield _lateness(measured)
    yield _latency(measured)
    yield _cost(measured)


def _lateness(measured: Sequence[Measured]) -> Table:
    return Table(
        "Loads: how late each turn wakes",
        (
            *("loop and load", "median, µs", "99 %, µs", "skipped, ‰"),
            *("C 50 %", "C 99 %", "C missed, ‰", "ratio 50 %", "ratio 99 %"),
        ),
        tuple(_lateness_row(one) for one in measured),
        (
            f"C: a bare loop at the same rate and with the daemon's scheduling, under the same load, that is "
            f"beside the daemon; which is measured in turn with it, {TURN_S:g} s each or less, without it"
            if any(one.bare for one in measured)
            else NO_COMPILER,
            measured[0].condition,
        ),
    )


def _lateness_row(one: Measured) -> tuple[Cell, ...]:
    own = tuple(1e6 * each for each in one.lateness_s)
    name = f"{one.rate_hz:g} Hz, {one.load.name}"
    if one.bare is None:
        return (name, *own, 1000 * one.skipped / one.due, None, None, None, None, None)
    other = tuple(one.bare.percentile_us(share) for share in (50, 99))
    return (
        name,
        *own,
        1000 * one.skipped / one.due,
        *other,
        1000 * one.bare.skipped / one.bare.due,
        *(mine / its for mine, its in zip(own, other, strict=True)),
    )


def _latency(measured: Sequence[Measured]) -> Table:
    return Table(
        "Loads: from a sample put to its estimate received in another process",
        ("loop and load", "whole, µs", "behind the wake-up, µs", "echo, µs", "echo 99 %, µs", "ratio"),
        tuple(_latency_row(one) for one in measured),
        (
            "medians; the echo is a bare one over Zenoh, there and back, in the same seconds; ratio: what "
            "lies beyond the wait for the tick (half an echo there, all behind the wake-up) over the echo",
        ),
    )


def _latency_row(one: Measured) -> tuple[Cell, ...]:
    name = f"{one.rate_hz:g} Hz, {one.load.name}"
    if not all(one.latency.values()):
        return (name, None, None, None, None, None)
    whole, behind, echo = (float(np.median(one.latency[part])) / 1e3 for part in ("whole", "behind", "echo"))
    worst = float(np.percentile(one.latency["echo"], 99)) / 1e3
    return name, whole, behind, echo, worst, (behind + echo / 2) / echo


def _cost(measured: Sequence[Measured]) -> Table:
    return Table(
        "Loads: what the daemon takes",
        ("loop and load", "of one core, %", "memory, MB", "after, min", "slope, kB/min"),
        tuple(_cost_row(one) for one in measured),
        (
            f"slope: a line through the memory at the ends of turns of {TURN_S:g} s, if there are three",
            "for ten minutes a daemon fills what it keeps for others",
        ),
    )


def _cost_row(one: Measured) -> tuple[Cell, ...]:
    at_s, held = np.array(one.memory, dtype=np.float64).T
    slope = float(np.polyfit(at_s / 60, held / 1e3, 1)[0]) if len(at_s) > 2 else None
    name = f"{one.rate_hz:g} Hz, {one.load.name}"
    return name, 100 * one.processor, held[-1] / 1e6, at_s[-1] / 60, slope
