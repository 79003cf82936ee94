"""A session read again, when it is known between what its figures are, and when it was worst."""

from dataclasses import dataclass

import numpy as np

from vsensor.messages import BIT_ESTIMATE, SENSOR_TICK
from vsensor.recording.columns import read_columns
from vsensor.recording.reader import Session
from vsensor.report.figures import Extent
from vsensor.report.gather import Story, late
from vsensor.report.ticks import BIT, BIT_TORQUE, FIELDS, Floats, Ticks, joined, ticks_of

BINS = 90
"""Of the portrait, each way."""
PER_DECADE = 15
"""Bins of the lateness,"""
LEAST_MS, USUAL_MS = 1e-3, 10.0
"""from the one on, up to the other at least."""


class Portrait:
    """How often the bit had which speed (rad/s) with which torque (N·m)."""

    def __init__(self, speed: Extent, torque: Extent) -> None:
        self._reach = [
            (each.least, each.greatest) if np.isfinite(each.least) else (0.0, 1.0) for each in (speed, torque)
        ]
        self.counts, self.speeds, self.torques = self._counted(np.empty(0), np.empty(0))

    def add(self, ticks: Ticks) -> None:
        """Count ticks of which both are known."""
        known = np.isfinite(ticks[BIT]) & np.isfinite(ticks[BIT_TORQUE])
        self.counts += self._counted(ticks[BIT][known], ticks[BIT_TORQUE][known])[0]

    def _counted(self, speed: Floats, torque: Floats) -> tuple[Floats, Floats, Floats]:
        return np.histogram2d(speed, torque, bins=BINS, range=self._reach)


class Lateness:
    """How often the loop woke how late."""

    def __init__(self, most_s: float) -> None:
        decades = np.log10(max(USUAL_MS, most_s * 1e3) / LEAST_MS)
        self.edges_ms = LEAST_MS * 10 ** (np.arange(np.ceil(decades * PER_DECADE) + 1) / PER_DECADE)
        self.counts: Floats = np.zeros(len(self.edges_ms) - 1)

    def add(self, late_s: Floats) -> None:
        """Count ticks, those that came sooner than the first bin in that."""
        known = late_s[np.isfinite(late_s)] * 1e3
        self.counts += np.histogram(np.clip(known, self.edges_ms[0], self.edges_ms[-1]), self.edges_ms)[0]


@dataclass
class Again:
    """What is told by a second reading."""

    closely: Ticks
    """The ticks of which some answer is for the worst stretch,"""
    portrait: Portrait
    lateness: Lateness | None
    """None where no loop ran."""


def read_again(session: Session, story: Story, worst: tuple[int, int]) -> Again:
    """Read a session of which this is the story, and this (ns) its worst stretch."""
    portrait = Portrait(story.extents[BIT], story.extents[BIT_TORQUE])
    latest = story.lateness_s.greatest
    lateness = None if np.isnan(latest) else Lateness(latest)
    closely: list[Ticks] = []
    wanted = {BIT_ESTIMATE: FIELDS, SENSOR_TICK: ("lateness_ns",)}
    for piece in read_columns(session, wanted):
        if BIT_ESTIMATE in piece:
            ticks = ticks_of(piece[BIT_ESTIMATE])
            portrait.add(ticks)
            own = ticks.of(_within(ticks, worst))
            closely += [own] if len(own) or not closely else []
        if lateness is not None and SENSOR_TICK in piece:
            lateness.add(late(piece[SENSOR_TICK]))
    return Again(joined(closely), portrait, lateness)


def _within(ticks: Ticks, stretch: tuple[int, int]) -> np.ndarray:
    times = np.array([ticks.confirmed_ns, ticks.time_ns, ticks.forecast_ns])
    return np.asarray(np.any((times >= stretch[0]) & (times <= stretch[1]), axis=0))
