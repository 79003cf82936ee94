"""The string in space, along the well's path: a ribbon wound up by its twist, coloured by shear stress."""

from collections.abc import Iterator

import numpy as np

from vsensor.view.batches import Batch, Floats, Labels, Strokes
from vsensor.view.charts.chart import Axis, Scale, axis
from vsensor.view.palette import GREY, WHITE, opaque, scale
from vsensor.view.part import AlongString, Every

EVERY_NS = 400_000_000
RADIUS = 0.035
"""Of the ribbon, the string's length being one: as thin as it is, it could not be seen."""
RUNGS = 90
"""Bars across the ribbon, evenly along the string."""
BAR_AT = np.array([0.30, 0.0, -1.0])
BAR_LONG = 0.5
"""Where the scale of colours stands, and how tall it is."""


class Twist(AlongString):
    """The newest profile in space. Everything is drawn in lengths of the string; labels tell metres."""

    def __init__(self, entity: str) -> None:
        super().__init__()
        self._entity = entity
        self._stress = Scale(0.0)
        self._every = Every(EVERY_NS)

    def batches(self) -> Iterator[Batch]:
        """The ribbon, some times a second, as soon as it is known how the string lies."""
        depth = np.array(self._profile.depth_m)
        if not len(depth) or len(depth) != len(self._description.depth_m) or not self._every.due(self.at_ns):
            return
        stations = np.linspace(0.0, depth[-1], RUNGS)
        path = self._path(depth, stations)
        turned = np.interp(
            stations, depth, twist(depth, self._torque, np.array(self._description.compliance_rad_nm_m))
        )
        stress = np.abs(np.interp(stations, depth, self._profile.shear_stress_pa)) / 1e6
        legend = self._stress.follow(stress)
        colours = opaque(scale(legend.shares(stress)))
        one, other = _edges(path, turned)
        bars = tuple(np.stack(ends) for ends in zip(one, other, strict=True))
        yield Strokes(f"{self._entity}/ribbon", self.at_ns, bars, colours, 5.0)
        yield from self._labels(self.at_ns, depth, path, turned[-1])
        yield from self._legend(self.at_ns, legend.ticks(), legend.shares(legend.ticks()), legend)

    @property
    def _torque(self) -> Floats:
        return np.array(self._profile.torque_nm)

    def _path(self, depth: Floats, stations: Floats) -> Floats:
        told = self._description
        east, north, down = (
            np.interp(stations, depth, column)
            for column in (told.east_m, told.north_m, told.vertical_depth_m)
        )
        return np.asarray(np.stack([east, north, -down], axis=1) / depth[-1])

    def _labels(self, at_ns: int, depth: Floats, path: Floats, turned: float) -> Iterator[Batch]:
        ticks = axis(0.0, float(depth[-1])).ticks()
        ticks = ticks[ticks <= depth[-1]]
        share = np.linspace(0.0, 1.0, RUNGS)
        places = [
            [np.interp(at / depth[-1], share, path[:, column]) for column in range(3)]
            for at in ticks.tolist()
        ]
        places = [*(np.array(places) - [0.12, 0.0, 0.0]), path[-1] - [0.0, 0.0, 0.08]]
        way = "behind" if turned >= 0 else "ahead of"
        told = f"the bit is {abs(turned) / (2 * np.pi):.2f} turns {way} the top"
        texts = (*(f"{at:.0f} m" for at in ticks.tolist()), told)
        colours = (*(GREY,) * len(ticks), WHITE)
        yield Labels(f"{self._entity}/labels", at_ns, np.array(places), texts, colours)

    def _legend(self, at_ns: int, ticks: Floats, shares: Floats, legend: Axis) -> Iterator[Batch]:
        steps = np.linspace(0.0, 1.0, 33)
        heights = BAR_AT + steps[:, None] * [0.0, 0.0, BAR_LONG]
        bar = tuple(heights[at : at + 2] for at in range(len(steps) - 1))
        yield Strokes(f"{self._entity}/scale", at_ns, bar, opaque(scale(steps[1:])), 12.0)
        places = BAR_AT + [0.09, 0.0, 0.0] + shares[:, None] * [0.0, 0.0, BAR_LONG]
        title = np.add(BAR_AT, [0.0, 0.0, BAR_LONG + 0.06])
        texts = (*map(legend.text, ticks.tolist()), "shear stress, MPa")
        yield Labels(
            f"{self._entity}/scale/labels", at_ns, np.vstack([places, title]), texts, (GREY,) * len(texts)
        )


def twist(depth: Floats, torque: Floats, compliance: Floats) -> Floats:
    """How far each station has turned against the top, rad: the integral of T/(GJ); shapes (n,)."""
    twisted = torque * compliance
    steps = np.diff(depth) * (twisted[1:] + twisted[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(steps)])


def _edges(path: Floats, turned: Floats) -> tuple[Floats, Floats]:
    """Both edges of the ribbon, shape (n, 3) each: across the path, turned about it."""
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    aside = np.cross(along, np.array([0.0, 1.0, 0.0]))
    level = np.linalg.norm(aside, axis=1) < 1e-6  # it points north
    aside[level] = [1.0, 0.0, 0.0]
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    above = np.cross(along, aside)
    reach = RADIUS * (np.cos(turned)[:, None] * aside + np.sin(turned)[:, None] * above)
    return path + reach, path - reach
