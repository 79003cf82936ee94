"""A channel that tells the very same value on and on, while the other one moves: a reading that has frozen.

Drives and gateways do so when what they read from is gone, and many say nothing of it. Noise alone would
change the last digit of a reading that lives. Where both stand still, as before the string turns, nothing is
held against it, nor where the configuration says that a channel is without noise.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Rig
from vsensor.quality import Reason
from vsensor.saved import Saved

LASTING_S = 3.0
"""A stiff drive's speed, read in coarse steps, may well repeat for a second."""
MOVED = 20.0
"""Standard deviations of its noise that the other must have moved by meanwhile: noise alone never does."""
MOST_TICKS = 1 << 53
"""A recorded state that tells of more was damaged: numbers beyond are not whole ones any more."""


class Run(NamedTuple):
    """A value that a channel repeats: for how many ticks, and between what the other moved meanwhile."""

    value: float
    ticks: int
    low: float
    high: float

    def on(self, value: float, other: float) -> "Run":
        """The run with one more tick; a new one where the value is another."""
        if value != self.value:
            return Run(value, 1, other, other)
        return Run(value, self.ticks + 1, min(self.low, other), max(self.high, other))


NO_RUN = Run(math.nan, 0, math.inf, -math.inf)


class _Reading:
    """One channel of the two."""

    def __init__(self, reason: Reason, silent: Reason, least: int, moved: float) -> None:
        self._reason = int(reason)
        self._silent = int(silent)
        self._least = least
        self._moved = moved
        self.run = NO_RUN

    def take(self, value: float, other: float, reasons: int) -> int:
        if reasons & self._silent:  # what stands there is no reading, but the last one held
            self.run = NO_RUN
            return 0
        self.run = run = self.run.on(value, other)
        frozen = run.ticks > self._least and run.high - run.low > self._moved
        return self._reason if frozen else 0

    def flags(self, values: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.uint32]:
        flags = np.zeros(len(values), np.uint32)
        before = np.append(self.run.value, values[:-1])
        begins = np.flatnonzero(values != before)
        bounds = np.concatenate(([0], begins[begins > 0], [len(values)]))
        long = np.diff(bounds) + np.where(bounds[:-1] == 0, self.run.ticks, 0) > self._least
        for start, end in zip(bounds[:-1][long], bounds[1:][long], strict=True):
            held = self.run if start == 0 and values[0] == self.run.value else NO_RUN
            low = np.minimum.accumulate(np.append(held.low, others[start:end]))[1:]
            high = np.maximum.accumulate(np.append(held.high, others[start:end]))[1:]
            ticks = held.ticks + np.arange(1, end - start + 1)
            flags[start:end][(ticks > self._least) & (high - low > self._moved)] = self._reason
        self._follow(values, others, int(begins[-1]) if len(begins) else 0)
        return flags

    def _follow(self, values: NDArray[np.float64], others: NDArray[np.float64], begun: int) -> None:
        """Take up the run in which the values end, which began there, or is the one from before."""
        value, moved = float(values[-1]), others[begun:]
        held = self.run if value == self.run.value and begun == 0 and values[0] == value else NO_RUN
        low, high = min(held.low, float(moved.min())), max(held.high, float(moved.max()))
        self.run = Run(value, held.ticks + len(moved), low, high)


class Frozen:
    """Watches both channels' values at the ticks."""

    def __init__(self, rig: Rig) -> None:
        measured, least = rig.measurement, round(LASTING_S * rig.loop.rate)
        torque, speed = measured.torque_noise, measured.speed_noise
        self._torque = _Reading(
            Reason.FROZEN_TORQUE, Reason.STALE_TORQUE, least, MOVED * speed if torque else math.inf
        )
        self._speed = _Reading(
            Reason.FROZEN_SPEED, Reason.STALE_SPEED, least, MOVED * torque if speed else math.inf
        )

    def forget(self) -> None:
        """Begin anew."""
        self._torque.run = self._speed.run = NO_RUN

    def take(self, torque: float, speed: float, reasons: int) -> int:
        """The next tick's values, and flags of what is wrong with them; returns those of what is besides."""
        return self._torque.take(torque, speed, reasons) | self._speed.take(speed, torque, reasons)

    def flags(self, torque: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.uint32]:
        """The same of n ticks with which nothing is wrong, shape (n,)."""
        if not len(torque):
            return np.zeros(0, np.uint32)
        return self._torque.flags(torque, speed) | self._speed.flags(speed, torque)

    def save(self) -> list[list[float | None]]:
        """What is remembered, as plain values: JSON knows neither NaN nor infinity."""
        return [
            [number if math.isfinite(number) else None for number in reading.run]
            for reading in (self._torque, self._speed)
        ]

    def restore(self, saved: Saved) -> None:
        """Take up what `save` gave. Raises ValueError for what it cannot have given."""
        for reading, row in zip((self._torque, self._speed), saved.row(2), strict=True):
            value, ticks, low, high = row.row(4)
            reading.run = Run(
                _number(value, NO_RUN.value),
                ticks.whole(0, MOST_TICKS),
                _number(low, NO_RUN.low),
                _number(high, NO_RUN.high),
            )


def _number(saved: Saved, otherwise: float) -> float:
    number = saved.or_none(Saved.number)
    return otherwise if number is None else number
