"""Contestants timed in turn, so that whatever else the machine does falls on all of them alike."""

import time
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

LEAST_ROUNDS = 5


class Times(NamedTuple):
    """How long one contestant's work took, ns: the middle of all rounds, and the best."""

    median: float
    least: float


def alternate(
    works: Mapping[str, Callable[[], object]],
    seconds: float,
    clock: Callable[[], int] = time.perf_counter_ns,
) -> dict[str, Times]:
    """Time each work once a round, for about `seconds` and at least five rounds.

    Every other round goes backwards, so that none always comes after the same other. The works are
    run once before the clock starts: that compiles them and fills the caches. `clock` tells ns.
    """
    for work in works.values():
        work()
    taken: dict[str, list[int]] = {name: [] for name in works}
    order = list(works)
    end = time.perf_counter() + seconds
    rounds = 0
    while rounds < LEAST_ROUNDS or time.perf_counter() < end:
        for name in order:
            begun = clock()
            works[name]()
            taken[name].append(clock() - begun)
        order.reverse()
        rounds += 1
    return {name: Times(float(np.median(ns)), float(min(ns))) for name, ns in taken.items()}
