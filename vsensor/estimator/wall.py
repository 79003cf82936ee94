"""The wall's friction worked out from the well's path: the soft string."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vsensor.config import Component
from vsensor.config.well import Station, Wellbore
from vsensor.estimator.component import buoyed_weight
from vsensor.estimator.tension import hanging_weight
from vsensor.estimator.wellpath import Floats, Integers, Path, direction, well_path

CELL = 1.0
"""Side forces are summed over lengths of at most so much, m: short beside the arcs of a well."""
_GAUSS = 0.5 / 3**0.5
"""Gauss and Legendre's two points, which integrate a cubic exactly, stand so far from a cell's middle."""


class Contact(NamedTuple):
    """How a turning string lies on the wall, at n points from the top down; each stands for some length."""

    depth: Floats
    """Measured depth, m, shape (n,)."""
    span: Floats
    """Length of string that a point stands for, m, shape (n,)."""
    part: Integers
    """Which component it belongs to, shape (n,)."""
    tension: Floats
    """Effective tension, buoyed weight below less weight on bit, N; negative in compression; shape (n,)."""
    side_force: Floats
    """Between string and wall, N/m, shape (n,)."""


class WallFriction(NamedTuple):
    """Coulomb friction between the wall and each of n components, N·m."""

    kinetic: Floats
    """While it turns, shape (n,)."""
    static: Floats
    """At which it breaks away, shape (n,)."""


def wall_friction(
    string: Sequence[Component], survey: Sequence[Station], wellbore: Wellbore | None
) -> WallFriction:
    """The wall's friction on each component: by the well's path if there is one, else as told per metre."""
    if wellbore is None:
        return WallFriction(
            np.array([part.coulomb_friction * part.length for part in string]),
            np.array([part.static_friction * part.length for part in string]),
        )
    lies = contact(string, well_path(survey), wellbore)
    pressed = np.bincount(lies.part, weights=lies.side_force * lies.span, minlength=len(string))
    lever = pressed * [part.tool_joint_diameter / 2 for part in string]
    return WallFriction(wellbore.friction_factor * lever, wellbore.static_friction_factor * lever)


def contact(string: Sequence[Component], path: Path, wellbore: Wellbore) -> Contact:
    """The soft string, on the wall throughout (Johancsik et al. 1984; Sheppard, Wick and Burgess 1987).

    It hangs from surface and turns, so that friction points around the hole and takes no tension: F is the
    weight in mud below less the weight on bit. The wall bears what of F and weight acts across the well,
    |F dt/ds + w_across|, in compression too. No buckling.
    """
    ends = np.cumsum([0.0, *(part.length for part in string)])
    depth, span = _points(ends, path.depth)
    part = np.searchsorted(ends[1:-1], depth, side="right")
    tension = hanging_weight(string, depth, wellbore.mud_density, path) - wellbore.weight_on_bit
    tangent, bend = direction(path, depth)
    across = np.array([0.0, 0.0, 1.0]) - tangent * tangent[:, 2:]
    weight = np.array([buoyed_weight(p, wellbore.mud_density) for p in string])
    side_force = np.linalg.norm(tension[:, None] * bend + weight[part, None] * across, axis=1)
    return Contact(depth, span, part, tension, side_force)


def _points(ends: Floats, stations: Floats) -> tuple[Floats, Floats]:
    """Depths at which to look, and the length that each stands for: two in a cell, no cell across an edge."""
    total = ends[-1]
    even = np.linspace(0.0, total, int(np.ceil(total / CELL)) + 1)
    edges = np.unique(np.concatenate([even, ends, stations[stations < total]]))
    cells = np.diff(edges)
    middle = edges[:-1] + cells / 2
    points = np.stack([middle - _GAUSS * cells, middle + _GAUSS * cells], axis=1)
    return points.ravel(), np.repeat(cells / 2, 2)
