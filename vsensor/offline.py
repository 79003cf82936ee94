"""The sensor without a clock: samples of a file through the same intake and estimator as live."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from vsensor import checkpoint
from vsensor.config import Rig
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import (
    CONFIRMED,
    FORECAST,
    NOW,
    OFF_BOTTOM,
    SPEED,
    SPEED_STD,
    TORQUE,
    TORQUE_STD,
)
from vsensor.intake import NS, Input, Intake
from vsensor.messages import Event, Sample, State
from vsensor.quality import Reason, verdict

CHUNK = 10_000
"""Ticks given to the estimator at once."""


class Offline:
    """One rig's sensor over recorded samples."""

    def __init__(self, rig: Rig) -> None:
        self.intake = Intake(rig)
        self._estimator = Estimator(rig)

    @property
    def tuning(self) -> NDArray[np.float64]:
        """Corrections of delay, top-drive inertia and wall friction that the record made, as shares; (3,)."""
        return self._estimator.tuning

    def take_up(self, state: State) -> None:
        """Go on from a recorded state; ValueError where it does not fit this rig."""
        checkpoint.take_up(state, self.intake, self._estimator)

    def estimates(
        self, samples: Iterable[tuple[str, Sample | Event]]
    ) -> Iterator[Mapping[str, NDArray[np.generic]]]:
        """Yield the estimates table of `contracts` in chunks of columns, one row a tick."""
        inputs = self._inputs(samples)
        while chunk := list(islice(inputs, CHUNK)):
            yield from map(self._run, _unbroken(chunk))

    def _inputs(self, samples: Iterable[tuple[str, Sample | Event]]) -> Iterator[Input]:
        for topic, sample in samples:
            yield from self.intake.take(topic, sample)

    def _run(self, inputs: list[Input]) -> Mapping[str, NDArray[np.generic]]:
        if inputs[0].number == 0:
            self._estimator.restart()
        if inputs[0].longer_by:
            self._estimator.lengthen(inputs[0].longer_by)
        times = np.array([given.time_ns for given in inputs])
        values, reasons, delays = self._estimator.run(
            [given.motor_torque for given in inputs],
            [given.motor_speed for given in inputs],
            [int(given.reasons) | (OFF_BOTTOM if given.off_bottom else 0) for given in inputs],
        )
        confirmed, forecast = (
            times + sign * np.rint(delay * NS).astype(np.int64)
            for sign, delay in zip((-1, 1), delays, strict=True)
        )
        return {
            "time_s": _seconds(times),
            "confirmed_time_s": np.where(np.isnan(values[:, CONFIRMED]), np.nan, _seconds(confirmed)),
            **_answer("confirmed", values[:, CONFIRMED:]),
            **_answer("now", values[:, NOW:]),
            "forecast_time_s": np.where(np.isnan(values[:, FORECAST]), np.nan, _seconds(forecast)),
            **_answer("forecast", values[:, FORECAST:]),
            "quality": _verdicts(reasons),
        }


def _seconds(times_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """The nearest doubles: as doubles before they are divided, the nanoseconds would be rounded twice."""
    return np.array([time_ns / NS for time_ns in times_ns.tolist()])


def _verdicts(reasons: NDArray[np.uint32]) -> NDArray[np.str_]:
    distinct, place = np.unique(reasons, return_inverse=True)
    return np.array([verdict(Reason(int(flags))).name.lower() for flags in distinct])[place]


def _answer(kind: str, columns: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    return {
        f"{kind}_speed_rad_s": columns[:, SPEED],
        f"{kind}_speed_std_rad_s": columns[:, SPEED_STD],
        f"{kind}_torque_nm": columns[:, TORQUE],
        f"{kind}_torque_std_nm": columns[:, TORQUE_STD],
    }


def _unbroken(inputs: list[Input]) -> Iterator[list[Input]]:
    """Split where the grid was laid anew, and where the string has become longer."""
    start = 0
    for at in range(1, len(inputs)):
        if inputs[at].number == 0 or inputs[at].longer_by:
            yield inputs[start:at]
            start = at
    yield inputs[start:]
