"""The highest rate: faster and faster, until slots pass without a turn."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from vsensor.bench.compiler import NO_COMPILER, compiler
from vsensor.bench.live import rig_at
from vsensor.bench.table import Cell, Table
from vsensor.bench.turns import LOADS, Measured, under_loads
from vsensor.bench.wakes import build_bare_loop

RATES_HZ = (500.0, 700.0, 1000.0, 1400.0, 2000.0, 2800.0, 4000.0)
"""Each half as long a slot again, two steps to the double."""
ALLOWED = 1e-3
"""So many slots may be skipped beyond those that the bare loop in C misses."""


def tables(
    seconds: float, say: Callable[[str], None], rates_hz: Sequence[float] = RATES_HZ
) -> Iterator[Table]:
    """Run the demonstration's daemon at ever higher rates for `seconds` each, until it does not keep up.

    Raises VsensorError where a process fails.
    """
    cc = compiler()
    tried: list[Measured] = []
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as name:
        bare = build_bare_loop(cc, Path(name)) if cc else None
        for rate in rates_hz:
            tried += under_loads(rig_at(rate), Path(name), bare, seconds, say, LOADS[:1])
            if not keeps_up(tried[-1]):
                break
    yield Table(
        "Limit: faster, until slots pass without a turn",
        ("loop", "slots", "skipped", "skipped, ‰", "C missed, ‰", "of one core, %", "keeps up"),
        tuple(_row(one) for one in tried),
        (
            f"for {seconds:g} s each, alone but for the rig; C: a bare loop at the same rate, in turn; "
            f"keeps up: skips no more than that one misses, and {ALLOWED:.1%}"
            if cc
            else NO_COMPILER,
            tried[0].condition,
        ),
    )


def keeps_up(one: Measured) -> bool:
    """Whether no more slots were skipped than a bare loop missed, and a few."""
    missed = one.bare.skipped / one.bare.due if one.bare else 0.0
    return one.skipped / one.due <= missed + ALLOWED


def _row(one: Measured) -> tuple[Cell, ...]:
    missed = 1000 * one.bare.skipped / one.bare.due if one.bare else None
    return (
        f"{one.rate_hz:g} Hz",
        one.due,
        one.skipped,
        1000 * one.skipped / one.due,
        missed,
        100 * one.processor,
        "yes" if keeps_up(one) else "no",
    )
