"""The whole tick: window, top drive, descent, march, score; beside the time that a tick has."""

from collections.abc import Iterator, Sequence

import numpy as np

from vsensor.bench.rounds import alternate
from vsensor.bench.table import Cell, Table
from vsensor.bench.well import deep_well
from vsensor.estimator.estimator import Estimator

TICKS = 50
"""Ticks run at once: some ten milliseconds."""


def tables(seconds: float, rates_hz: Sequence[float]) -> Iterator[Table]:
    """Time ticks for `seconds`, the rates together. Raises ConfigError for an impossible rate."""
    yield Table(
        "The whole tick: 5 km of string in ten components",
        (
            "rate, Hz",
            "steps a tick",
            "confirmed alone, µs",
            "now and forecast too, µs",
            "as the daemon calls it, µs",
            "of its time, %",
        ),
        tuple(_row(rate, seconds / len(rates_hz)) for rate in rates_hz),
        (
            "medians; the first two over ticks run in one call, the third called from Python for each tick",
            "the yardstick is the tick's own time, 1 / rate; the last column is the third in its share",
        ),
    )


def _row(rate: float, seconds: float) -> tuple[Cell, ...]:
    whole, confirmed = Estimator(deep_well(rate)), _confirmed_alone(rate)
    time = np.arange(TICKS) / rate
    torque, speed = 25e3 + 2e3 * np.sin(1.3 * time), 12 + np.cos(1.3 * time)
    one_by_one = list(zip(torque.tolist(), speed.tolist(), strict=True))

    def each() -> None:
        for t, w in one_by_one:
            whole.step(t, w)

    works = {
        "confirmed": lambda: confirmed.run(torque, speed),
        "whole": lambda: whole.run(torque, speed),
        "each": each,
    }
    taken = alternate(works, seconds)
    alone, full, called = (taken[name].median / TICKS / 1e3 for name in works)
    return rate, whole.steps_per_tick, alone, full, called, 100 * called * rate / 1e6


def _confirmed_alone(rate: float) -> Estimator:
    """An estimator that marches a single step, so that next to nothing but the descent is left.

    No user has a reason to ask for that, hence no setting does it.
    """
    estimator = Estimator(deep_well(rate))
    estimator._model = estimator._model._replace(now=1, forecast=1)
    estimator.reset()
    return estimator
