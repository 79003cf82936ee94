"""The string's kernels, march and observer, beside the very same loops in C, compiled while we run."""

import ctypes
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from vsensor.bench.compiler import FLAGS, NO_COMPILER, compiler, compiler_version, library
from vsensor.bench.record import alone, drilled
from vsensor.bench.rounds import Times, alternate
from vsensor.bench.table import Cell, Table
from vsensor.bench.well import deep_well
from vsensor.config import Rig
from vsensor.errors import VsensorError
from vsensor.estimator import observe
from vsensor.estimator.ahead import predict, reach, read_beyond
from vsensor.estimator.along import keep_returned
from vsensor.estimator.arrays import fill, flat
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.learn import load_in_force
from vsensor.estimator.line import FADE_SPEED
from vsensor.estimator.ring import SPARE
from vsensor.estimator.rise import rise
from vsensor.estimator.score import HORIZONS
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import NONE, Model, State, fresh, strand
from vsensor.jit import compiled

RATE_HZ = 1000.0
"""The kernels step at this rate."""
RECORD_S = 20.0
"""So much has been drilled before."""
STEPS = 1000
"""Steps of the observer at once, which take about a millisecond: short beside what else the machine does."""
MARCHES = 4
CORRECTIONS = 20
INNOVATION = 0.01
"""rad/s, one way and the other in turn, so that the string stays what it is."""
AGREEMENT = 1e-12
"""Ours and theirs may differ by so much of the largest number: C may fuse multiply and add."""
COMPARED = ("waves", "returned", "junctions", "balances", "rock", "told", "marching", "ahead")
MEASURES = {"balances": "waves"}
"""What the largest is taken from, where not from the array itself: balances are differences of torques."""


class Case(NamedTuple):
    """What both are given."""

    rig: Rig
    model: Model
    state: State
    """After a record of drilling."""
    torque: Floats
    """At the string, N·m, for what follows; shape (STEPS,)."""
    innovation: Floats
    """rad/s, shape (CORRECTIONS,)."""


class Contestant(NamedTuple):
    """March, step and correction of one make."""

    march: Callable[[], object]
    step: Callable[[], object]
    correct: Callable[[], object]
    state: State
    """What they leave behind; each has its own."""


def tables(seconds: float) -> Iterator[Table]:
    """Time the kernels for `seconds` altogether. Raises VsensorError where C says something else."""
    case = deep_case()
    contestants = {"ours": _ours(case)}
    if cc := compiler():
        for flags in FLAGS:
            told = f"{flags} -DFADE_SPEED={FADE_SPEED!r} -DSPARE={SPARE}"
            contestants[flags] = _theirs(case, library(cc, "line.c", told))
    for contestant in contestants.values():
        run_once(contestant)
    for flags, contestant in contestants.items():
        check(contestant.state, contestants["ours"].state, flags)
    marches = alternate({name: c.march for name, c in contestants.items()}, seconds / 3)
    steps = alternate({name: c.step for name, c in contestants.items()}, seconds / 3)
    corrections = alternate({name: c.correct for name, c in contestants.items()}, seconds / 3)
    sections = len(case.model.line.impedance)
    yield Table(
        f"The string's kernels at {RATE_HZ:g} Hz, 5 km of string in {sections} sections",
        ("kernel", "made by", "median, ns", "best, ns", "ours / this"),
        (
            *_rows("march, a section", marches, MARCHES * junctions_marched(case)),
            *_rows("observer's step, a section", steps, STEPS * sections),
            *_rows("correction, a number", corrections, CORRECTIONS * corrected(case)),
        ),
        (
            f"C by {compiler_version(cc)}, the numbers the same within {AGREEMENT:g}" if cc else NO_COMPILER,
            f"march: with the bit's load law; a whole one, {march_steps(case.model)} steps of 1 ms over the "
            f"junctions that matter, takes {marches['ours'].median / MARCHES / 1e3:.0f} µs",
            f"an innovation corrects {corrected(case)} numbers, which takes "
            f"{corrections['ours'].median / CORRECTIONS / 1e3:.0f} µs",
        ),
    )


def deep_case() -> Case:
    """A deep string that drills, observed for a while."""
    rig = deep_well(RATE_HZ)
    torque, speed = drilled(rig, round(RECORD_S * RATE_HZ) + STEPS)
    estimator = Estimator(rig)
    estimator.run(torque[:-STEPS], speed[:-STEPS])
    model, state = estimator._model, estimator._state
    turns = np.resize([INNOVATION, -INNOVATION], CORRECTIONS)
    return Case(rig, model, state, model.passed * torque[-STEPS:], turns)


def march_steps(model: Model) -> int:
    """Steps of a whole march: what is told, and what is read until the next has come as far."""
    return reach(model, HORIZONS) + read_beyond(model.shares, model.steps)


def junctions_marched(case: Case) -> int:
    """How many junctions a march solves: the one below section i matters while its wave can reach the bit."""
    trips, reach = case.model.line.round_trip, march_steps(case.model)
    below = np.cumsum(trips[::-1])[::-1] - trips
    return int(np.clip(reach - below, 0, reach).sum())


def corrected(case: Case) -> int:
    """How many numbers of the past an innovation corrects."""
    gains = case.model.gains
    return int(np.minimum(case.model.inside, gains.waves.shape[2]).sum() + gains.told[0].size)


def run_once(contestant: Contestant) -> None:
    """Let a contestant do everything, so that there is something to compare."""
    contestant.step()
    contestant.correct()
    contestant.march()


def check(theirs: State, ours: State, made: str) -> None:
    """Raise VsensorError where two contestants do not agree."""
    for name in COMPARED:
        a, b = getattr(theirs, name), getattr(ours, name)
        largest = np.abs(getattr(ours, MEASURES.get(name, name))).max()
        worst = float(np.abs(a - b).max() / largest)
        if not worst <= AGREEMENT:
            raise VsensorError(f"line.c ({made}) and ours differ in {name} by {worst:.1e} of the largest")


def _own(case: Case) -> State:
    state = fresh(case.model, case.rig.bit, case.rig.tuning)
    fill(state, flat(case.state))
    return state


def _ours(case: Case) -> Contestant:
    state = _own(case)
    return Contestant(
        lambda: _march_all(case.model, state),
        lambda: _step_all(case.model, alone(_as_before(state, case)), case.torque),
        lambda: _correct_all(case.model, alone(state), case.innovation),
        state,
    )


@compiled
def _march_all(model: Model, state: State) -> None:
    for _ in range(MARCHES):
        state.course[:] = NONE  # timed whole, not in shares of it
        predict(model, state, reach(model, HORIZONS))


def _as_before(state: State, case: Case) -> State:
    """The state with the ends of its strings as they were before anything was stepped."""
    for name in ("junctions", "balances", "rock"):
        getattr(state, name)[:] = getattr(case.state, name)
    return state


@compiled
def _step_all(model: Model, state: State, torque: Floats) -> None:
    string = strand(state, 0)
    load = load_in_force(state.learned, model.bit_rate)
    first = state.ticks[0] * model.steps
    for k in range(torque.shape[0]):
        string.rock[0] *= model.fade
        rise(model, load, state, first + k)
        observe.turn_by_torque(model.line, model.drive_rates[0], string, first + k, torque[k])
        keep_returned(model.line, state.waves[0], state.junctions[0], first + k, state.returned)


@compiled
def _correct_all(model: Model, state: State, innovation: Floats) -> None:
    string, gains, level = strand(state, 0), model.gains, state.level[0]
    last = state.ticks[0] * model.steps + model.steps - 1
    for k in range(innovation.shape[0]):
        observe.correct_ends(gains, level, string, innovation[k])
        observe.correct_told(gains.told[level], state.told, last, innovation[k : k + 1])
        observe.correct_waves(gains.waves[level], model.inside, state.waves, last, innovation[k : k + 1])


class _Line(ctypes.Structure):
    _fields_ = [("sections", ctypes.c_int64)] + [
        (name, ctypes.c_void_p) for name in ("impedance", "round_trip", "viscous", "kinetic", "held")
    ]


_OF_STRING = ("waves", "returned", "junctions", "balances", "rock", "told", "ahead")


class _String(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in _OF_STRING] + [
        (name, ctypes.c_int64) for name in ("size", "room")
    ]


def _theirs(case: Case, c: ctypes.CDLL) -> Contestant:
    model, state = case.model, _own(case)
    sections, number = len(model.line.impedance), ctypes.c_int64
    line = ctypes.byref(_Line(sections, *(_at(array) for array in model.line[:5])))
    law = load_in_force(state.learned, model.bit_rate)
    load = (ctypes.c_double * len(law))(*law)
    drive = (ctypes.c_double * 2)(float(model.drive_rates[0]), model.fade)
    rings = [_at(getattr(state, name)) for name in _OF_STRING]
    string = ctypes.byref(_String(*rings, state.waves.shape[2], state.ahead.shape[1]))
    first = int(state.ticks[0]) * model.steps
    gains = [np.ascontiguousarray(of[state.level[0]]) for of in _gains(model)]
    lag = number(gains[-1].shape[1])

    def march() -> None:
        span = (number(first + model.steps - 1), number(march_steps(model)))
        c.foretell(
            line, load, string, *span, ctypes.c_double(model.fade), _at(state.marching), number(MARCHES)
        )

    def step() -> None:
        _as_before(state, case)
        c.turn(line, load, drive, string, number(first), _at(case.torque), number(STEPS))

    def correct() -> None:
        span = (number(sections), lag, string, number(first + model.steps - 1))
        c.correct(*map(_at, gains), _at(model.inside), *span, _at(case.innovation), number(CORRECTIONS))

    return Contestant(march, step, correct, state)


def _gains(model: Model) -> tuple[Floats, Floats, Floats]:
    return model.gains.state, model.gains.waves, model.gains.told


def _at(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _rows(kernel: str, times: Mapping[str, Times], units: int) -> Iterator[tuple[Cell, ...]]:
    ours = times["ours"].median
    for name, taken in times.items():
        made = "ours (numba)" if name == "ours" else f"C, {name}"
        ratio = None if name == "ours" else ours / taken.median
        yield kernel, made, taken.median / units, taken.least / units, ratio
