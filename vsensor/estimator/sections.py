"""The string cut into sections on a grid of internal steps: what the kernels run over."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Component
from vsensor.config.well import Station, Wellbore
from vsensor.estimator import component
from vsensor.estimator.wall import wall_friction

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

FINEST = 32
"""At most so many internal steps in a tick; components shorter than one are lumped with a neighbour."""

LONGEST_STEP_S = 4e-3
"""Delays are rounded to half a step: at 5 Hz, beyond which a string tells next to nothing of its bit,
that turns a wave's phase by at most π/50 at any junction, however long the string. Below 7.8 Hz, FINEST
steps a tick are longer: ticks carry no more than half their rate there, which half a step turns by π/64."""
LEAST_STEPS = 200
"""Of a string's travel time at the least: a short one swings faster, and tells of more. Steps of 4 ms would
put the ends of its collars wrong by a twentieth of their length, and with them their ringing."""
SHORTEST_STEP_S = 0.25e-3
"""But no finer for that: half of it is 0.4 m, and work grows with the steps in a second."""
MORE = 1.5
"""A short string may have up to so many times as many, where its components' ends lie better on their grid:
waves ring on between them, and a wrong pitch is soon out of phase."""
CLEARLY = 1 / 3
"""Better is what leaves so small a share of the rounding: more steps take more time."""


class Line(NamedTuple):
    """M sections in series, top down, and the M + 1 junctions above, between and below them."""

    impedance: Floats
    """ζ of each section, N·m·s/rad, shape (M,)."""
    round_trip: Integers
    """2θ of each section in internal steps, even and at least 2, shape (M,)."""
    viscous: Floats
    """Friction lumped at each junction: N·m·s/rad, shape (M + 1,)."""
    kinetic: Floats
    """Coulomb friction of each junction while it turns, N·m, shape (M + 1,)."""
    static: Floats
    """The torque at which a resting junction breaks away, N·m, shape (M + 1,)."""
    depth: Floats
    """Each junction's travel time from the top, in internal steps, not rounded, shape (M + 1,)."""


class _Part(NamedTuple):
    length: float
    impedance: float
    delay: float
    viscous: float
    kinetic: float
    static: float


def steps_per_tick(string: Sequence[Component], tick_s: float) -> int:
    """How many internal steps a tick takes so that every component lasts one and rounding stays small."""
    delays = [component.delay(part) for part in string]
    wanted = max(SHORTEST_STEP_S, sum(delays) / LEAST_STEPS)
    least = math.ceil(tick_s / min(LONGEST_STEP_S, wanted, *delays) * (1 - 1e-12))
    most = int(MORE * least) if wanted < LONGEST_STEP_S else least
    least, most = min(FINEST, least), min(FINEST, most)
    # Not of the topmost, which pipe is added to: on the same grid the string goes on as it was.
    fixed = delays[1:] or delays
    best = min(range(least, most + 1), key=lambda steps: _rounding(fixed, tick_s / steps))
    clearly = _rounding(fixed, tick_s / best) < CLEARLY * _rounding(fixed, tick_s / least)
    return best if clearly else least


def _rounding(delays: Sequence[float], step_s: float) -> float:
    """By what share of itself a component is longer or shorter on the grid, that which is so the most."""
    return max(abs(max(round(delay / step_s), 1) * step_s / delay - 1) for delay in delays)


def cut(
    string: Sequence[Component],
    step_s: float,
    section_length: float,
    survey: Sequence[Station] = (),
    wellbore: Wellbore | None = None,
) -> Line:
    """Cut a string into sections of at most `section_length` (m) on a grid of `step_s`.

    Distributed friction is lumped by the trapezoid rule: half of each section's at either end.
    Depths, not lengths, are rounded to the grid, so that the error never adds up.
    """
    parts = _parts(string, step_s, section_length, survey, wellbore)
    depth = np.cumsum([0.0, *(part.delay for part in parts)]) / step_s
    return Line(
        impedance=np.array([part.impedance for part in parts]),
        round_trip=_round_trips(depth),
        viscous=_at_junctions([part.viscous for part in parts]),
        kinetic=_at_junctions([part.kinetic for part in parts]),
        static=_at_junctions([part.static for part in parts]),
        depth=depth,
    )


def stretched(line: Line, share: float) -> Line:
    """The line with all its delays longer by a share, as of a softer steel: c and ζ go with √G."""
    depth = line.depth * (1 + share)
    return line._replace(impedance=line.impedance / (1 + share), round_trip=_round_trips(depth), depth=depth)


def longest_round_trips(line: Line, share: float) -> Integers:
    """Bounds of all round trips with delays longer by up to a share, internal steps, shape (M,)."""
    # A section has its ends on the grid, stretched or not: each time a step, two there and back, is rounding.
    return np.asarray(np.ceil((line.round_trip + 2) * (1 + share)).astype(np.int64) + 2)


def _round_trips(depth: Floats) -> Integers:
    on_grid = np.floor(depth + 0.5).astype(np.int64)
    for i in range(1, len(on_grid)):  # whatever the rounding of a sum of floats: no section without a step
        on_grid[i] = max(on_grid[i], on_grid[i - 1] + 1)
    return np.asarray(2 * np.diff(on_grid))


def junction_depths(
    string: Sequence[Component],
    step_s: float,
    section_length: float,
    survey: Sequence[Station] = (),
    wellbore: Wellbore | None = None,
) -> Floats:
    """Where a string so cut has its junctions, m along it from the top, shape (M + 1,)."""
    parts = _parts(string, step_s, section_length, survey, wellbore)
    return np.cumsum([0.0, *(part.length for part in parts)])


def _parts(
    string: Sequence[Component],
    step_s: float,
    section_length: float,
    survey: Sequence[Station],
    wellbore: Wellbore | None,
) -> list[_Part]:
    pieces = [piece for part in string for piece in _pieces(part, section_length, wellbore)]
    friction = wall_friction(pieces, survey, wellbore)
    return _merged([_part(*rubs) for rubs in zip(pieces, *friction, strict=True)], step_s)


def _pieces(part: Component, section_length: float, wellbore: Wellbore | None) -> list[Component]:
    rubs = part.viscous_friction or part.static_friction or (wellbore and wellbore.static_friction_factor)
    count = math.ceil(part.length / section_length) if rubs else 1
    return [part.model_copy(update={"length": part.length / count})] * count


def _part(piece: Component, kinetic: float, static: float) -> _Part:
    return _Part(
        piece.length,
        component.impedance(piece),
        component.delay(piece),
        piece.viscous_friction * piece.length,
        float(kinetic),
        float(static),
    )


def _merged(parts: list[_Part], step_s: float) -> list[_Part]:
    """Lump what is shorter than a step, keeping inertia ζθ and compliance θ/ζ.

    First with others that are, until they last one; what is left then with the shorter of its neighbours, so
    that its inertia stays near where it is.
    """
    least = step_s * (1 - 1e-9)
    rest: list[_Part] = []
    for part in parts:
        short = rest and max(rest[-1].delay, part.delay) < least
        rest.append(_lump(rest.pop(), part) if short else part)
    merged: list[_Part] = []
    for below, part in enumerate(rest, 1):
        if part.delay >= least or len(rest) == 1:
            merged.append(part)
        elif below == len(rest) or (merged and merged[-1].delay <= rest[below].delay):
            merged.append(_lump(merged.pop(), part))
        else:
            rest[below] = _lump(part, rest[below])
    return merged


def _lump(a: _Part, b: _Part) -> _Part:
    inertia = a.impedance * a.delay + b.impedance * b.delay
    compliance = a.delay / a.impedance + b.delay / b.impedance
    return _Part(
        a.length + b.length,
        math.sqrt(inertia / compliance),
        math.sqrt(inertia * compliance),
        a.viscous + b.viscous,
        a.kinetic + b.kinetic,
        a.static + b.static,
    )


def _at_junctions(of_sections: list[float]) -> Floats:
    halves = np.asarray(of_sections) / 2
    return np.append(halves, 0.0) + np.insert(halves, 0, 0.0)
