"""`vsensor bench`: speed, throughput and lateness, each beside its yardstick."""

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer
from rich import box
from rich import table as rich_table
from rich.console import Console

from vsensor.errors import VsensorError

if TYPE_CHECKING:
    from vsensor.bench.table import Cell, Table


FILE_WIDTH = 150
"""Columns of a table that goes to a file: no figure of it is cut off."""


class Benchmark(StrEnum):
    """The benchmarks by name."""

    KERNEL = "kernel"
    READING = "reading"
    OFFLINE = "offline"
    DAY = "day"
    LIVE = "live"
    LOADS = "loads"
    LIMIT = "limit"
    VIEW = "view"
    START = "start"


RATES_HZ = (100.0, 1000.0)


def bench(
    which: Annotated[list[Benchmark] | None, typer.Argument(help="By default, all of them.")] = None,
    *,
    seconds: Annotated[
        float,
        typer.Option(help="To measure for; offline and day run 720 s of samples for each.", min=0.001),
    ] = 5.0,
    rate: Annotated[
        list[float] | None, typer.Option(help="Hz, for whole ticks and live; by default 100 and 1000.")
    ] = None,
    json_file: Annotated[
        typer.FileTextWrite | None,
        typer.Option("--json", lazy=False, encoding="utf-8", help="Write the figures to this file."),
    ] = None,
) -> None:
    """Measure kernels beside C, sessions read, an hour offline, and the sensor at work: losses, lateness."""
    from vsensor.bench.machine import machine
    from vsensor.bench.well import deep_well

    rates = rate or RATES_HZ
    for hz in rates:
        deep_well(hz)  # an impossible rate is refused before anything is measured
    console = Console(width=None if sys.stdout.isatty() else FILE_WIDTH)
    here = machine()
    console.print("; ".join(f"{name} {value}" for name, value in here.items()), highlight=False)
    tables: list[Table] = []
    with console.status("") as status:
        for name in which or list(Benchmark):
            for table in _run(name, seconds, rates, status.update):
                tables.append(table)
                _show(console, table)
    if json_file is not None:
        figures = {"machine": here, "tables": [table.as_dict() for table in tables]}
        json.dump(figures, json_file, indent=2, ensure_ascii=False)


def _run(
    name: Benchmark, seconds: float, rates: Sequence[float], say: Callable[[str], None]
) -> "Iterator[Table]":
    if name is Benchmark.KERNEL:
        from vsensor.bench import kernel, tick

        say("the line's kernels, ours and C in turn")
        yield from kernel.tables(seconds)
        say("whole ticks")
        yield from tick.tables(seconds, rates)
    elif name is Benchmark.READING:
        from vsensor.bench import reading

        say("sessions, by columns and message by message")
        yield from reading.tables(seconds)
    elif name is Benchmark.OFFLINE:
        from vsensor.bench import offline

        say("samples of a file, as fast as they go")
        yield from offline.tables(seconds)
    elif name is Benchmark.DAY:
        from vsensor.bench import day

        yield from day.tables(seconds, say)
    elif name is Benchmark.START:
        from vsensor.bench import start

        yield from start.tables(rates[0], say)
    elif name is Benchmark.LOADS:
        from vsensor.bench import loads

        yield from loads.tables(rates, seconds, say)
    elif name is Benchmark.LIMIT:
        from vsensor.bench import limit

        yield from limit.tables(seconds, say)
    elif name is Benchmark.VIEW:
        try:
            from vsensor.bench import view
        except ModuleNotFoundError as error:
            raise VsensorError(
                f"bench view needs {error.name}, an extra: pip install 'vsensor[view]'"
            ) from error

        yield from view.tables(rates, seconds, say)
    else:
        from vsensor.bench import live

        yield from live.tables(seconds, rates, say)


def _show(console: Console, table: "Table") -> None:
    shown = rich_table.Table(
        title=table.title,
        title_justify="left",
        caption="\n".join(table.notes),
        caption_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
    )
    for at, heading in enumerate(table.columns):
        words = isinstance(table.rows[0][at], str)
        longest = max(map(len, heading.split()))
        shown.add_column(heading, justify="left" if words else "right", no_wrap=words, min_width=longest)
    for row in table.rows:
        shown.add_row(*map(_shown, row))
    console.print(shown)


def _shown(cell: "Cell") -> str:
    if cell is None:
        return "–"
    if isinstance(cell, float):
        return f"{cell:,.0f}" if abs(cell) >= 100 else f"{cell:.3g}"
    return f"{cell:,}" if isinstance(cell, int) else cell
