"""The search for the highest rate goes on while the loop keeps up, and no further."""

from collections.abc import Iterator

import numpy as np
import pytest

from vsensor.bench import limit
from vsensor.bench.turns import LOADS, Measured
from vsensor.bench.wakes import Wakes
from vsensor.config import Rig


def run_at(rate: float, skipped: int, missed: int) -> Measured:
    beside = Wakes(np.zeros(1, np.int64), 10_000, missed)
    return Measured(rate, LOADS[0], (0.0, 0.0), 10_000, skipped, beside, {}, 0.5, [(60.0, 0)], True)


@pytest.mark.parametrize(
    ("skipped", "missed", "keeps_up"), [(0, 0, True), (10, 0, True), (11, 0, False), (40, 30, True)]
)
def test_what_a_bare_loop_misses_too_is_the_machines_doing(skipped: int, missed: int, keeps_up: bool) -> None:
    assert limit.keeps_up(run_at(1000.0, skipped, missed)) is keeps_up


def test_no_rate_is_tried_beyond_the_first_that_is_too_high(monkeypatch: pytest.MonkeyPatch) -> None:
    def measured(rig: Rig, *_given: object) -> Iterator[Measured]:
        yield run_at(rig.loop.rate, 500 if rig.loop.rate > 1000 else 0, 0)

    monkeypatch.setattr(limit, "under_loads", measured)
    (table,) = limit.tables(1.0, lambda _words: None)
    assert [(row[0], row[-1]) for row in table.rows] == [
        ("500 Hz", "yes"),
        ("700 Hz", "yes"),
        ("1000 Hz", "yes"),
        ("1400 Hz", "no"),
    ]
