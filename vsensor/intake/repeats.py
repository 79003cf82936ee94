"""Readings that are passed on more often than they are read: a sample that repeats the last one is none.

A controller that reads its drive ten times a second and is asked a hundred times tells each reading ten
times. Taken as it comes that is a stair, late by half a step on average, each step a blow that no string was
dealt. A channel that does so shows it by its runs of equal samples: hardly one is of a single sample, and
they are much of one length. What is read in coarse steps repeats itself too, but for as long as it happens
to. Runs are counted and picked, never summed, so that samples by columns come to the very same.
"""

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.saved import Saved

Integers = NDArray[np.int64]

BLOCK = 32
"""Runs from which it is told how long the next ones are."""
FEW = 3
"""So few of them may be shorter than what is told of them, and as few longer."""
FROM = 2
"""Samples of a reading that was told more than once;"""
ALIKE = 2
"""and of such readings the longest take no more than so many times what the shortest take."""
MOST = 1 << 53
"""A recorded state that tells of more samples was damaged."""


@dataclass(slots=True)
class Heard:
    """What is remembered of a channel's samples."""

    beat: int = 0
    """How often each reading is told, by the last whole block; 0 where that is as often as it is read."""
    value: float = math.nan
    """The newest sample's value, NaN where there was none,"""
    time_ns: int = 0
    """its time,"""
    told: int = 0
    """and how often it was told."""
    begun_ns: int = 0
    """When the block under way began,"""
    runs: list[int] = field(default_factory=list)
    """and how long the runs were that have ended in it."""


class Looked(NamedTuple):
    """What comes of n samples."""

    new: NDArray[np.bool_]
    """Which ones are new readings, shape (n,)."""
    heard: Heard
    """What is then remembered."""


class Repeats:
    """Which of one channel's samples are no new readings."""

    def __init__(self, longest_ns: int) -> None:
        """A reading that is told for longer than `longest_ns` would leave a gap: then each sample counts."""
        self._longest_ns = longest_ns
        self.heard = Heard()

    def forget(self) -> None:
        """Begin anew; how often a reading is told stays."""
        self.heard = Heard(self.heard.beat)

    def is_one(self, time_ns: int, value: float) -> bool:
        """Whether the next sample is no new reading. One that was sent twice is for others to refuse."""
        heard = self.heard
        if value != heard.value:
            self._begin(time_ns)
            heard.value, heard.time_ns, heard.told = value, time_ns, 1
            return False
        if time_ns == heard.time_ns:
            return False
        heard.time_ns = time_ns
        heard.told += 1
        return heard.told <= heard.beat

    def _begin(self, time_ns: int) -> None:
        """Another run begins, and one may have ended."""
        heard = self.heard
        if not heard.told:
            heard.begun_ns = time_ns
            return
        heard.runs.append(heard.told)
        if len(heard.runs) == BLOCK:
            heard.beat = 0
            if heard.runs.count(1) < FEW:  # else the shortest are of one: arrays so small take their time
                bounds_ns = np.array([heard.begun_ns, time_ns])
                heard.beat = int(self._beats(np.array(heard.runs), bounds_ns)[0])
            heard.begun_ns, heard.runs = time_ns, []

    def _beats(self, runs: Integers, bounds_ns: Integers) -> Integers:
        """How often a reading is told, by each of n blocks: runs (n BLOCK,), bounds (n + 1,)."""
        blocks = np.sort(runs.reshape(-1, BLOCK), axis=1)
        shortest, longest = blocks[:, FEW - 1], blocks[:, BLOCK - FEW]
        lasts_ns = longest * (np.diff(bounds_ns) / blocks.sum(axis=1))
        known = (shortest >= FROM) & (longest <= ALIKE * shortest) & (lasts_ns <= self._longest_ns)
        return np.where(known, longest, 0)

    def look(self, times_ns: Integers, values: NDArray[np.float64]) -> Looked:
        """What comes of the next n samples, each later than the one before, shapes (n,)."""
        heard, place = self.heard, np.arange(len(values))
        begins = np.flatnonzero(values != np.append(heard.value, values[:-1]))
        # A run under way began before the first of these.
        starts = np.append(-heard.told, begins) if heard.told else begins
        runs = np.append(np.array(heard.runs, np.int64), np.diff(starts))
        full = len(runs) // BLOCK * BLOCK
        ends = begins[len(begins) - len(runs) + np.arange(BLOCK, full + 1, BLOCK) - 1]
        bounds_ns = np.append(heard.begun_ns if heard.told else times_ns[0], times_ns[ends])
        beats = np.append(heard.beat, self._beats(runs[:full], bounds_ns))
        beats = beats[(len(heard.runs) + np.arange(len(starts))) // BLOCK]
        run = np.searchsorted(starts, place, side="right") - 1
        told = place - starts[run] + 1
        return Looked(
            (told == 1) | (told > beats[run]),
            Heard(
                beat=int(beats[-1]),
                value=float(values[-1]),
                time_ns=int(times_ns[-1]),
                told=int(told[-1]),
                begun_ns=int(bounds_ns[-1]),
                runs=runs[full:].tolist(),
            ),
        )

    def save(self) -> list[Any]:
        """What is remembered, as plain values: JSON knows no NaN."""
        heard = self.heard
        value = heard.value if heard.told else None
        return [heard.beat, value, heard.time_ns, heard.told, heard.begun_ns, list(heard.runs)]

    def restore(self, saved: Saved, limit: float, latest_ns: int) -> None:
        """Take up what `save` gave. Raises ValueError for what it cannot have given."""
        beat, value, time_ns, told, begun_ns, runs = saved.row(6)
        newest = value.or_none(lambda number: number.number(-limit, limit))
        self.heard = Heard(
            beat=beat.whole(0, MOST),
            value=math.nan if newest is None else newest,
            time_ns=time_ns.whole(-latest_ns, latest_ns),
            told=told.whole(0, 0) if newest is None else told.whole(1, MOST),
            begun_ns=begun_ns.whole(-latest_ns, latest_ns),
            runs=[run.whole(1, MOST) for run in runs.rows()],
        )
        if len(self.heard.runs) >= BLOCK or (self.heard.runs and newest is None):
            raise runs.wrong(f"a list of fewer than {BLOCK}, and of none where there is no value,")
