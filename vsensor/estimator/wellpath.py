"""The path of a well from the stations of its survey: minimum curvature."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config.well import Station

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


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
