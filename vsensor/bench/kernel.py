"""The line's kernels, descent and march, beside the very same loops in C, compiled while we run."""

import ctypes
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from vsensor.bench.compiler import FLAGS, NO_COMPILER, compiler, compiler_version, library
from vsensor.bench.rounds import Times, alternate
from vsensor.bench.table import Cell, Table
from vsensor.bench.well import deep_well
from vsensor.errors import VsensorError
from vsensor.estimator.line import FADE_SPEED, descend, march
from vsensor.estimator.load import Load, load_of
from vsensor.estimator.sections import Floats, Line, cut
from vsensor.jit import compiled

RATE_HZ = 1000.0
"""The kernels step at this rate."""
STEPS = 2000
"""Steps of a descent, which takes about half a millisecond: short beside whatever else the machine does."""
MARCHES = 4
AGREEMENT = 1e-12
"""Ours and theirs may differ by so much of the largest number: C may fuse multiply and add."""


class Case(NamedTuple):
    """What both are given."""

    line: Line
    load: Load
    torque: Floats
    speed: Floats
    reach: int
    """Steps of a march: what the waves in the string foretell."""


class Results(NamedTuple):
    """What a contestant leaves behind; each has its own."""

    waves: Floats
    returned: Floats
    junctions: Floats
    bottom: Floats
    marching: Floats
    told: Floats


class Contestant(NamedTuple):
    """Descent and march of one make."""

    descend: Callable[[], object]
    march: Callable[[], object]
    results: Results


def tables(seconds: float) -> Iterator[Table]:
    """Time descent and march for `seconds` altogether. Raises VsensorError where C says something else."""
    case = deep_case()
    contestants = {"ours": _ours(case)}
    if cc := compiler():
        for flags in FLAGS:
            contestants[flags] = _theirs(case, library(cc, "line.c", f"{flags} -DFADE_SPEED={FADE_SPEED!r}"))
    for contestant in contestants.values():
        contestant.descend()
        contestant.march()
    for flags, contestant in contestants.items():
        check(contestant.results, contestants["ours"].results, flags)
    descents = alternate({name: c.descend for name, c in contestants.items()}, seconds / 2)
    marches = alternate({name: c.march for name, c in contestants.items()}, seconds / 2)
    sections = len(case.line.impedance)
    yield Table(
        f"The line's kernels: time for one step of one section, 5 km of string in {sections} sections",
        ("kernel", "made by", "median, ns", "best, ns", "ours / this"),
        (
            *_rows("descent", descents, STEPS * sections),
            *_rows("march", marches, MARCHES * junctions_marched(case)),
        ),
        (
            f"C by {compiler_version(cc)}, the numbers the same within {AGREEMENT:g}" if cc else NO_COMPILER,
            f"march: with the bit's load law; a whole one, {case.reach} steps of 1 ms over the "
            f"junctions that matter, takes {marches['ours'].median / MARCHES / 1e3:.0f} µs",
        ),
    )


def deep_case() -> Case:
    """A deep string that drills, torque and speed swinging and with the noise of real sensors."""
    rig = deep_well(RATE_HZ)
    line = cut(rig.string, 1 / RATE_HZ, rig.estimator.section_length)
    random = np.random.default_rng(1)
    phase = 2 * np.pi * 0.2 / RATE_HZ * np.arange(STEPS)
    torque = 25e3 + 2e3 * np.sin(phase) + rig.measurement.torque_noise * random.standard_normal(STEPS)
    speed = 12 + np.cos(phase) + rig.measurement.speed_noise * random.standard_normal(STEPS)
    return Case(line, load_of(rig.bit, 1 / RATE_HZ), torque, speed, int(line.round_trip.sum()))


def junctions_marched(case: Case) -> int:
    """How many junctions a march solves: the one below section i matters while its wave can reach the bit."""
    trips = case.line.round_trip
    below = np.cumsum(trips[::-1])[::-1] - trips
    return int(np.clip(case.reach - below, 0, case.reach).sum())


def check(theirs: Results, ours: Results, made: str) -> None:
    """Raise VsensorError where two contestants do not agree."""
    for name, a, b in zip(Results._fields, theirs, ours, strict=True):
        worst = float(np.abs(a - b).max() / np.abs(b).max())
        if not worst <= AGREEMENT:
            raise VsensorError(f"line.c ({made}) and ours differ in {name} by {worst:.1e} of the largest")


def _results(case: Case) -> Results:
    sections = len(case.line.impedance)
    size = 1 << int(STEPS + case.reach).bit_length()
    return Results(
        waves=np.zeros((sections, size)),
        returned=np.zeros((sections, size)),
        junctions=np.zeros(sections + 1),
        bottom=np.zeros((2, STEPS)),
        marching=np.zeros(sections + 1),
        told=np.zeros((2, case.reach)),
    )


def _ours(case: Case) -> Contestant:
    r = _results(case)
    return Contestant(
        lambda: _descend_all(case.line, r.waves, r.returned, r.junctions, case.torque, case.speed, r.bottom),
        lambda: _march_all(case.line, case.load, r.waves, case.reach, r.junctions, r.marching, r.told),
        r,
    )


@compiled
def _descend_all(
    line: Line,
    waves: Floats,
    returned: Floats,
    speeds: Floats,
    torque: Floats,
    speed: Floats,
    bottom: Floats,
) -> None:
    for step in range(torque.shape[0]):
        bottom[0, step], bottom[1, step] = descend(
            line, waves, returned, speeds, step, torque[step], speed[step]
        )


@compiled
def _march_all(
    line: Line, load: Load, waves: Floats, reach: int, start: Floats, speeds: Floats, told: Floats
) -> None:
    for _ in range(MARCHES):
        speeds[:] = start
        march(line, load, waves, STEPS - 1, reach, STEPS - 1, reach, 0.0, speeds, 0.0, told)


class _Line(ctypes.Structure):
    _fields_ = [("sections", ctypes.c_int64)] + [
        (name, ctypes.c_void_p) for name in ("impedance", "round_trip", "viscous", "kinetic", "held")
    ]


def _theirs(case: Case, c: ctypes.CDLL) -> Contestant:
    r = _results(case)
    line = ctypes.byref(_Line(len(case.line.impedance), *(a.ctypes.data for a in case.line)))
    load = (ctypes.c_double * len(case.load))(*case.load)
    number = ctypes.c_int64
    waves, size = _at(r.waves), number(r.waves.shape[1])

    def all_steps() -> None:
        given = (_at(case.torque), _at(case.speed), number(STEPS))
        c.descend(line, waves, _at(r.returned), size, _at(r.junctions), *given, _at(r.bottom))

    def all_marches() -> None:
        span = (number(STEPS - 1), number(case.reach))
        held = (_at(r.junctions), _at(r.marching), _at(r.told))
        c.march(line, load, waves, size, *span, *held, number(MARCHES))

    return Contestant(all_steps, all_marches, r)


def _at(array: Floats) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _rows(kernel: str, times: Mapping[str, Times], units: int) -> Iterator[tuple[Cell, ...]]:
    ours = times["ours"].median
    for name, taken in times.items():
        made = "ours (numba)" if name == "ours" else f"C, {name}"
        ratio = None if name == "ours" else ours / taken.median
        yield kernel, made, taken.median / units, taken.least / units, ratio
