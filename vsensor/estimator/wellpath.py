"""The wall's friction worked out from the well's path: minimum curvature and the soft string."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Component
from vsensor.config.well import Station, Wellbore
from vsensor.estimator.component import buoyed_weight

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

CELL = 1.0
"""Side forces are summed over lengths of at most so much, m: short beside the arcs of a well."""
_GAUSS = 0.5 / 3**0.5
"""Gauss and Legendre's two points, which integrate a cubic exactly, stand so far from a cell's middle."""


class Path(NamedTuple):
    """A well as K arcs of circles, one below the other; the last is straight and has no end.

    Vectors point north, east, down.
    """

    depth: Floats
    """Measured depth of each arc's top, m, shape (K,)."""
    place: Floats
    """Where each arc's top is, m from the well's own top, shape (K, 3)."""
    tangent: Floats
    """Unit vector along the well at each arc's top, shape (K, 3)."""
    normal: Floats
    """Unit vector across it, towards which the arc turns; zero where it is straight; shape (K, 3)."""
    curvature: Floats
    """In rad/m, shape (K,)."""


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


def well_path(survey: Sequence[Station]) -> Path:
    """The path by minimum curvature (Sawaryn and Thorogood 2005): from station to station an arc of a circle.

    `survey` begins at surface. Below its last station the well goes straight on.
    """
    depth = np.array([station.measured_depth for station in survey])
    down = np.array([station.inclination for station in survey])
    azimuth = np.array([station.azimuth for station in survey])
    tangent = np.stack([np.sin(down) * np.cos(azimuth), np.sin(down) * np.sin(azimuth), np.cos(down)], axis=1)
    above, below = tangent[:-1], tangent[1:]
    # The half angle by its tangent: exact where a cosine would round small angles away (Kahan).
    angle = 2 * np.arctan2(_norm(below - above), _norm(below + above))
    across = below - above * (above * below).sum(axis=1, keepdims=True)
    normal = across / np.maximum(_norm(across), np.finfo(float).tiny)[:, None]
    path = Path(
        depth,
        np.zeros_like(tangent),
        tangent,
        np.vstack([normal, np.zeros(3)]),
        np.append(angle / np.diff(depth), 0.0),
    )
    ways = _way(path, np.arange(len(angle)), np.diff(depth))
    return path._replace(place=np.vstack([np.zeros(3), np.cumsum(ways, axis=0)]))


def direction(path: Path, depth: Floats) -> tuple[Floats, Floats]:
    """Unit vector t along the well, and dt/ds in 1/m, at measured depths (n,): each of shape (n, 3)."""
    arc = _arc(path, depth)
    turned = (path.curvature[arc] * (depth - path.depth[arc]))[:, None]
    tangent, normal = path.tangent[arc], path.normal[arc]
    bend = path.curvature[arc, None] * (normal * np.cos(turned) - tangent * np.sin(turned))
    return tangent * np.cos(turned) + normal * np.sin(turned), bend


def place(path: Path, depth: Floats) -> Floats:
    """Where the well is at measured depths (n,): north, east and down of its top, m, shape (n, 3)."""
    arc = _arc(path, depth)
    return path.place[arc] + _way(path, arc, depth - path.depth[arc])


def vertical_depth(path: Path, depth: Floats) -> Floats:
    """True vertical depth at measured depths (n,), m."""
    return np.asarray(place(path, depth)[:, 2])


def contact(string: Sequence[Component], path: Path, wellbore: Wellbore) -> Contact:
    """The soft string, on the wall throughout (Johancsik et al. 1984; Sheppard, Wick and Burgess 1987).

    It hangs from surface and turns, so that friction points around the hole and takes no tension: F is the
    weight in mud below less the weight on bit. The wall bears what of F and weight acts across the well,
    |F dt/ds + w_across|, in compression too. No buckling.
    """
    ends = np.cumsum([0.0, *(part.length for part in string)])
    depth, span = _points(ends, path.depth)
    part = np.searchsorted(ends[1:-1], depth, side="right")
    weight = np.array([buoyed_weight(p, wellbore.mud_density) for p in string])
    bottoms = vertical_depth(path, ends)
    hangs = np.append(np.cumsum((weight * np.diff(bottoms))[::-1])[::-1], 0.0)
    tension = hangs[part + 1] - wellbore.weight_on_bit
    tension += weight[part] * (bottoms[part + 1] - vertical_depth(path, depth))
    tangent, bend = direction(path, depth)
    across = np.array([0.0, 0.0, 1.0]) - tangent * tangent[:, 2:]
    side_force = _norm(tension[:, None] * bend + weight[part, None] * across)
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


def _arc(path: Path, depth: Floats) -> Integers:
    """The arc that each depth lies on."""
    return np.asarray(np.searchsorted(path.depth, depth, side="right") - 1)


def _way(path: Path, arc: Integers, along: Floats) -> Floats:
    """Where one gets along the well (m, shape (n,)) from the tops of these arcs: the chord, shape (n, 3)."""
    half = (path.curvature[arc] * along / 2)[:, None]
    mean = path.tangent[arc] * np.cos(half) + path.normal[arc] * np.sin(half)
    return np.asarray(along[:, None] * mean * np.sinc(half / np.pi))


def _norm(vectors: Floats) -> Floats:
    return np.asarray(np.linalg.norm(vectors, axis=1))
