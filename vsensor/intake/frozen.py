"""A channel that tells the very same value on and on, while the other one moves: a reading that has frozen.

Drives and gateways do so when what they read from is gone, and many say nothing of it. Noise alone would
change the last digit of a reading that lives: where one seldom repeats itself, a fourth time is enough while
the string is turned, and such a channel is then as silent as one that tells nothing. One that is read in
coarse steps, or passed on more often than it is read, repeats itself now and then: for how long is usual the
channel itself tells. Where both stand still, as before the string turns, nothing is held against it, nor
where the configuration says that a channel is without noise. But where both seldom repeat themselves, and do
so together at the speed of a string that is turned, a gateway has lost the source of both.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Rig
from vsensor.quality import Reason
from vsensor.saved import Saved

LASTING_S = 3.0
"""A stiff drive's speed, read in coarse steps, may well repeat for a second: so long, at the start."""
KNOWN_S = 10.0
"""Once a channel was heard for so long, it is known what is usual for it:"""
UNUSUAL = 10
"""a repetition is held against it that is so many times longer than any before,"""
SURELY_S = 0.3
SURELY_TICKS = 10
"""and longer than both of these."""
SELDOM, MOST_RUNS = 200, 100_000
"""A channel repeats itself seldom where fewer than one run in so many does, of no more than so many;"""
BY_CHANCE = 3
"""it may yet come to runs of so many ticks: a reading has but so many digits."""
MOVED = 20.0
"""Standard deviations of its noise that the other must have moved by meanwhile: noise alone never does. A
speed beyond as many is one of a string that is turned."""
MOST_TICKS = 1 << 53
"""A recorded state that tells of more was damaged: numbers beyond are not whole ones any more."""

_FROZEN = int(Reason.FROZEN_TORQUE | Reason.FROZEN_SPEED)
_SILENT = int(Reason.STALE_TORQUE | Reason.STALE_SPEED)
_Number = float | NDArray[np.float64]


class Run(NamedTuple):
    """A value that a channel repeats: for how many ticks, and between what the other moved meanwhile."""

    value: float
    ticks: int
    low: float
    high: float

    def on(self, other: float) -> "Run":
        """The run with one more tick."""
        return Run(self.value, self.ticks + 1, min(self.low, other), max(self.high, other))


NO_RUN = Run(math.nan, 0, math.inf, -math.inf)


class _Reading:
    """One channel of the two."""

    def __init__(self, reason: Reason, rate: float, moved: float, turned: float) -> None:
        self._reason = int(reason)
        self._is_speed = reason is Reason.FROZEN_SPEED
        self._silent = int(Reason.STALE_SPEED if self._is_speed else Reason.STALE_TORQUE)
        self._surely = _surely(rate)
        self._lasting = max(self._surely, round(LASTING_S * rate))
        self._known = round(KNOWN_S * rate)
        self._moved = moved
        self._turned = turned
        self.run = NO_RUN
        self.before = 0
        """Ticks of the run before it,"""
        self.longest = 0
        """of the longest run that is usual,"""
        self.heard = 0
        """and of all runs that have ended."""
        self.runs = 0
        """So many have,"""
        self.repeats = 0
        """and so many of them were of more than one tick."""

    def forget(self) -> None:
        """Begin anew; what is usual stays."""
        self.run, self.before = NO_RUN, 0

    def take(self, value: float, other: float, reasons: int) -> int:
        if reasons & self._silent:  # what stands there is no reading, but the last one held
            self.run = NO_RUN
            return 0
        if value == self.run.value:
            self.run = run = self.run.on(other)
            return self._flag if self._is_frozen(run) else 0
        self._end()
        self.run = Run(value, 1, other, other)
        return 0

    def flags(
        self, values: NDArray[np.float64], others: NDArray[np.float64]
    ) -> tuple[NDArray[np.uint32], NDArray[np.int64]]:
        """Flags of n ticks, and how often each value was told, 0 where that is not unusual; shapes (n,)."""
        flags, held = np.zeros(len(values), np.uint32), np.zeros(len(values), np.int64)
        if values[0] != self.run.value:
            self._end()
        bounds = np.concatenate(([0], np.flatnonzero(np.diff(values)) + 1, [len(values)]))
        lengths = np.diff(bounds)
        lengths[0] += self.run.ticks
        least = BY_CHANCE if self._seldom(self.runs + len(lengths)) else self._surely
        done = 0
        for which in [*np.flatnonzero(lengths[:-1] > least).tolist(), len(lengths) - 1]:
            self._end_short(lengths[done:which])
            done = which + 1
            part = slice(bounds[which], bounds[which + 1])
            run = self.run if which == 0 else NO_RUN
            if self.seldom_repeats:
                held[part] = run.ticks + np.arange(1, lengths[which] - run.ticks + 1)
            self.run = self._go_on(run, float(values[part.start]), others[part], flags[part])
            if done < len(lengths):
                self._end()
        return flags, held

    def _go_on(self, held: Run, value: float, others: NDArray[np.float64], flags: NDArray[np.uint32]) -> Run:
        """Flag what is frozen of a run that goes on from another; returns the whole of it."""
        low = np.minimum.accumulate(np.append(held.low, others))[1:]
        high = np.maximum.accumulate(np.append(held.high, others))[1:]
        ticks = held.ticks + np.arange(1, len(others) + 1)
        frozen = (ticks > self._least()) & (high - low > self._moved)
        if self.seldom_repeats:
            frozen |= (ticks > BY_CHANCE) & (high > low) & self._is_turned(value, low, high)
        flags[frozen] = self._flag
        return Run(value, int(ticks[-1]), float(low[-1]), float(high[-1]))

    @property
    def _flag(self) -> int:
        return self._reason | (self._silent if self.seldom_repeats else 0)

    def _is_frozen(self, run: Run) -> bool:
        value, ticks, low, high = run
        if ticks <= BY_CHANCE:
            return False
        if high - low > self._moved and ticks > self._least():
            return True
        return self.seldom_repeats and high > low and bool(self._is_turned(value, low, high))

    def _least(self) -> int:
        """Ticks beyond which a run is unusual for what repeats itself."""
        least = self._surely if self.heard >= self._known else self._lasting
        return max(least, UNUSUAL * self.longest)

    @property
    def seldom_repeats(self) -> bool:
        """Whether that is known; where one is read less often from now on the run before says so."""
        return self.runs >= self._known and self.before <= 1 and self._seldom(self.runs)

    def _seldom(self, runs: int) -> bool:
        return self.repeats * SELDOM <= min(runs, MOST_RUNS)

    def _is_turned(self, value: float, low: _Number, high: _Number) -> "bool | np.bool_ | NDArray[np.bool_]":
        """Whether the string's top was turned all the while."""
        if self._is_speed:
            return abs(value) > self._turned
        return (low > self._turned) | (high < -self._turned)

    def _stood_still(self, run: Run) -> bool:
        return run.ticks > self._lasting and not run.high - run.low > self._moved

    def _end(self) -> None:
        """Take account of a run that has ended: where it says what is usual."""
        run = self.run
        if not run.ticks:
            return
        if run.ticks <= BY_CHANCE or not (self._stood_still(run) or self._is_frozen(run)):
            self.longest = max(self.longest, run.ticks)
        self.heard += run.ticks
        self.runs += 1
        self.repeats += run.ticks > 1
        self.before = run.ticks
        self.run = NO_RUN

    def _end_short(self, lengths: NDArray[np.intp]) -> None:
        """The same of runs that are none of those that could be frozen, nor still under way."""
        if len(lengths):
            self.longest = max(self.longest, int(lengths.max()))
            self.heard += int(lengths.sum())
            self.runs += len(lengths)
            self.repeats += int((lengths > 1).sum())
            self.before = int(lengths[-1])

    def save(self) -> list[float | None]:
        run = (number if math.isfinite(number) else None for number in self.run)
        return [*run, self.before, self.longest, self.heard, self.runs, self.repeats]

    def restore(self, saved: Saved) -> None:
        value, ticks, low, high, *counts = saved.row(9)
        self.run = Run(
            _number(value, NO_RUN.value),
            ticks.whole(0, MOST_TICKS),
            _number(low, NO_RUN.low),
            _number(high, NO_RUN.high),
        )
        self.before, self.longest, self.heard, self.runs, self.repeats = (
            count.whole(0, MOST_TICKS) for count in counts
        )


class Frozen:
    """Watches both channels' values at the ticks."""

    def __init__(self, rig: Rig) -> None:
        rate, torque, speed = rig.loop.rate, rig.measurement.torque_noise, rig.measurement.speed_noise
        moved, turned = MOVED * torque, MOVED * speed
        never = math.inf
        self._turned = turned if torque and speed else never
        self._surely = _surely(rate)
        self._torque = _Reading(Reason.FROZEN_TORQUE, rate, *((turned, turned) if torque else (never, never)))
        self._speed = _Reading(Reason.FROZEN_SPEED, rate, *((moved, turned) if speed else (never, never)))

    def forget(self) -> None:
        """Begin anew; what is usual stays."""
        self._torque.forget()
        self._speed.forget()

    def take(self, torque: float, speed: float, reasons: int) -> int:
        """The next tick's values, and flags of what is wrong with them; returns those of what is besides."""
        flags = self._torque.take(torque, speed, reasons) | self._speed.take(speed, torque, reasons)
        return flags | self._of_both()

    @property
    def silent(self) -> bool:
        """Whether both channels repeat themselves, as they do not, and are taken for silent."""
        return self._of_both() & _SILENT != 0

    def _of_both(self) -> int:
        ticks = min(self._torque.run.ticks, self._speed.run.ticks)
        if ticks <= BY_CHANCE or not abs(self._speed.run.value) > self._turned:
            return 0
        if not (self._torque.seldom_repeats and self._speed.seldom_repeats):
            return 0
        return _FROZEN | _SILENT if ticks > self._surely else _FROZEN

    def flags(self, torque: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.uint32]:
        """The same of n ticks with which nothing is wrong, shape (n,)."""
        if not len(torque):
            return np.zeros(0, np.uint32)
        of_torque, torque_held = self._torque.flags(torque, speed)
        of_speed, speed_held = self._speed.flags(speed, torque)
        flags, held = of_torque | of_speed, np.minimum(torque_held, speed_held)
        both = (held > BY_CHANCE) & (np.abs(speed) > self._turned)
        flags[both] |= _FROZEN
        flags[both & (held > self._surely)] |= _SILENT
        return flags

    def save(self) -> list[list[float | None]]:
        """What is remembered, as plain values: JSON knows neither NaN nor infinity."""
        return [reading.save() for reading in (self._torque, self._speed)]

    def restore(self, saved: Saved) -> None:
        """Take up what `save` gave. Raises ValueError for what it cannot have given."""
        for reading, row in zip((self._torque, self._speed), saved.row(2), strict=True):
            reading.restore(row)


def _surely(rate: float) -> int:
    return max(SURELY_TICKS, round(SURELY_S * rate))


def _number(saved: Saved, otherwise: float) -> float:
    number = saved.or_none(Saved.number)
    return otherwise if number is None else number
