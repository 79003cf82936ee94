"""The whole tick and its parts: observer, shadows, march, score; beside the time that a tick has."""

from collections.abc import Callable, Iterator, Sequence
from itertools import cycle
from typing import Self

import numpy as np

from vsensor.bench.record import alone, drilled
from vsensor.bench.rounds import alternate
from vsensor.bench.table import Cell, Table
from vsensor.bench.well import deep_well
from vsensor.config import Rig
from vsensor.estimator import study
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.inputs import enter, follow_bit, lasting
from vsensor.estimator.learn import lose_sight
from vsensor.estimator.observe import note_rest, observe, settle
from vsensor.estimator.ring import mask_of
from vsensor.estimator.rock import weigh_rock
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import Model, State
from vsensor.jit import compiled

TICKS = 50
"""Ticks run at once: about a millisecond."""
BEFORE_S = 65.0
"""The record is run so far before anything is timed, until law and string are known."""
TIMED_S = 20.0
"""So much of the record is gone through over and over."""
CONFIRMED, TUNED = range(2)
"""What is done of a tick: bit and string confirmed, and the shadows beside."""
CONFIRMED_LIMIT_US, WHOLE_LIMIT_US = 10.0, 500.0


def tables(seconds: float, rates_hz: Sequence[float]) -> Iterator[Table]:
    """Time ticks for `seconds`, the rates together. Raises ConfigError for an impossible rate."""
    yield Table(
        "The whole tick: 5 km of string in ten components",
        (
            "rate, Hz",
            "steps a tick",
            "confirmed alone, µs",
            "self-tuning too, µs",
            "everything, µs",
            "as the daemon calls it, µs",
            "of its time, %",
        ),
        tuple(_row(rate, seconds / len(rates_hz)) for rate in rates_hz),
        (
            "medians, on the record of a simulated rig that drills, over ticks run in one call, but for the "
            "last, called from Python for each; up to everything, each column does more than the one before",
            "confirmed alone: the observer with its corrections, of bit and string, and the law learned; "
            "self-tuning: shadows; everything: scores, and marches ahead, side by side as over a record",
            "the yardstick is the tick's own time, 1 / rate; the last column is the one before in its share; "
            f"asked for at 100 Hz: confirmed alone {CONFIRMED_LIMIT_US:g} µs, a whole tick "
            f"{WHOLE_LIMIT_US:g} µs at the most",
        ),
    )


def _row(rate: float, seconds: float) -> tuple[Cell, ...]:
    rig = deep_well(rate)
    before, timed = round(BEFORE_S * rate), max(1, round(TIMED_S * rate / TICKS)) * TICKS
    torque, speed = drilled(rig, before + timed)
    whole, called = Estimator(rig), Estimator(rig)
    for estimator in (whole, called):
        estimator.run(torque[:before], speed[:before])

    def in_turn(work: Callable[[Floats, Floats], object]) -> Callable[[], object]:
        parts = cycle(zip(torque[before:].reshape(-1, TICKS), speed[before:].reshape(-1, TICKS), strict=True))
        return lambda: work(*next(parts))

    def each(torques: Floats, speeds: Floats) -> None:
        for t, w in zip(torques.tolist(), speeds.tolist(), strict=True):
            called.step(t, w)

    works = {
        **{
            f"part {part}": in_turn(Part(rig, part).start(torque[:before], speed[:before]).run)
            for part in (CONFIRMED, TUNED)
        },
        "whole": in_turn(whole.run),
        "each": in_turn(each),
    }
    taken = alternate(works, seconds)
    spent = [taken[name].median / TICKS / 1e3 for name in works]
    return rate, whole.steps_per_tick, *spent, 100 * spent[-1] * rate / 1e6


class Part:
    """A sensor that does only a part of its tick.

    No user has a reason to ask for that, hence no setting does it.
    """

    def __init__(self, rig: Rig, part: int) -> None:
        self._part = part
        self._estimator = Estimator(rig)

    def start(self, torque: Floats, speed: Floats) -> Self:
        """Do everything for once."""
        self._estimator.run(torque, speed)
        return self

    def run(self, torque: Floats, speed: Floats) -> Floats:
        """Run n ticks; returns the confirmed bit speed and torque, shape (n, 2), whether known yet or not."""
        told = np.empty((len(torque), 2))
        of = self._estimator
        state = of._state if self._part == TUNED else alone(of._state)
        _run(of._model, state, torque, speed, self._part, told)
        return told


@compiled
def _run(model: Model, state: State, torque: Floats, speed: Floats, part: int, told: Floats) -> None:
    for k in range(torque.shape[0]):
        flags = enter(model, state, torque[k], speed[k], 0)
        follow_bit(model, state, False)
        if state.ticks[0] == 0:
            for which in range(state.waves.shape[0]):
                settle(model, state, which, state.inputs[0, 0], state.inputs[1, 0])
        doubts = lasting(model, state, flags)
        observe(model, state)
        note_rest(model, state)
        if doubts:
            lose_sight(state.learned)
        else:
            study.study_law(model, state)
            weigh_rock(model, state)
            if part == TUNED:
                study.study_string(model, state)
        at = study.confirmed_step(model, state) & mask_of(state.told.shape[2])
        for q in range(2):
            told[k, q] = state.told[0, q, at]
        state.ticks[0] += 1
