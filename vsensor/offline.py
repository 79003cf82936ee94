"""The sensor without a clock: samples of a file through the same intake and estimator as live."""

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vsensor import checkpoint
from vsensor.config import Rig
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import (
    CONFIRMED,
    FORECAST,
    NO_FORECAST,
    NOW,
    OFF_BOTTOM,
    SPEED,
    SPEED_STD,
    TORQUE,
    TORQUE_STD,
)
from vsensor.grid import NS, seconds
from vsensor.intake import Input, Intake
from vsensor.intake.arrivals import Arrivals, Feed, Inputs, by_columns
from vsensor.intake.stretch import laid
from vsensor.messages import State
from vsensor.quality import verdict

CHUNK = 10_000
"""Ticks given to the estimator at once."""


class Offline:
    """One rig's sensor over recorded samples."""

    def __init__(self, rig: Rig) -> None:
        self.intake = Intake(rig)
        self._estimator = Estimator(rig)

    @property
    def tuning(self) -> NDArray[np.float64]:
        """Corrections that the record made: see `Estimator.tuning`, shape (5,)."""
        return self._estimator.tuning

    def take_up(self, state: State) -> None:
        """Go on from a recorded state; ValueError where it does not fit this rig."""
        checkpoint.take_up(state, self.intake, self._estimator)

    def estimates(self, feed: Feed) -> Iterator[Mapping[str, NDArray[np.generic]]]:
        """Yield the estimates in chunks of columns, `tables.ESTIMATE_FIELDS`, one row a tick."""
        for inputs in self._inputs(feed):
            yield from map(self._run, _unbroken(inputs))

    def _inputs(self, feed: Feed) -> Iterator[Inputs]:
        """The ticks in chunks: those of columns as they come, those of single samples gathered."""
        waiting: list[Input] = []
        for come in feed:
            if isinstance(come, Arrivals):
                yield by_columns(waiting)
                waiting = []
                yield from laid(self.intake, come)
            else:
                waiting += self.intake.take(*come)
            if len(waiting) >= CHUNK:
                yield by_columns(waiting)
                waiting = []
        yield by_columns(waiting)

    def _run(self, inputs: Inputs) -> Mapping[str, NDArray[np.generic]]:
        if inputs.number[0] == 0:
            self._estimator.restart()
        if inputs.longer_by[0]:
            self._estimator.lengthen(float(inputs.longer_by[0]))
        times = inputs.time_ns
        values, reasons, delays = self._estimator.run(
            inputs.motor_torque,
            inputs.motor_speed,
            inputs.reasons | _flags(inputs),
        )
        confirmed, forecast = (
            times + sign * np.rint(delay * NS).astype(np.int64)
            for sign, delay in zip((-1, 1), delays, strict=True)
        )
        return {
            "time_s": seconds(times),
            "confirmed_time_s": np.where(np.isnan(values[:, CONFIRMED]), np.nan, seconds(confirmed)),
            **_answer("confirmed", values[:, CONFIRMED:]),
            **_answer("now", values[:, NOW:]),
            "forecast_time_s": np.where(np.isnan(values[:, FORECAST]), np.nan, seconds(forecast)),
            **_answer("forecast", values[:, FORECAST:]),
            "quality": _verdicts(reasons),
        }


def _flags(inputs: Inputs) -> NDArray[np.uint32]:
    off_bottom = np.where(inputs.off_bottom, OFF_BOTTOM, 0)
    return (off_bottom | np.where(inputs.forecast_shed, NO_FORECAST, 0)).astype(np.uint32)


def _verdicts(reasons: NDArray[np.uint32]) -> NDArray[np.str_]:
    distinct, place = np.unique(reasons, return_inverse=True)
    return np.array([verdict(int(flags)).name.lower() for flags in distinct])[place]


def _answer(kind: str, columns: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    return {
        f"{kind}_speed_rad_s": columns[:, SPEED],
        f"{kind}_speed_std_rad_s": columns[:, SPEED_STD],
        f"{kind}_torque_nm": columns[:, TORQUE],
        f"{kind}_torque_std_nm": columns[:, TORQUE_STD],
    }


def _unbroken(inputs: Inputs) -> Iterator[Inputs]:
    """Split where the grid was laid anew, and where the string has become longer."""
    count = len(inputs.number)
    cuts = np.flatnonzero((inputs.number == 0) | (inputs.longer_by != 0)).tolist()
    bounds = [0, *(cut for cut in cuts if cut), count] if count else []
    for start, end in pairwise(bounds):
        yield inputs.part(start, end)
