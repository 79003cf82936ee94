"""An answer held against the truth."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tests.cases import Columns

Floats = NDArray[np.float64]


class Answer(NamedTuple):
    """What was said of the bit, in SI; arrays of shape (n,), NaN where nothing was said."""

    time: Floats
    """The time that each answer is for, s."""
    speed: Floats
    speed_std: Floats
    torque: Floats
    torque_std: Floats


class Score(NamedTuple):
    """Errors of one answer from some time on."""

    speed: float
    """Rms error of bit speed, rad/s."""
    share: float
    """The same over the range of the true bit speed."""
    torque: float
    """Rms error of bit torque, N·m."""
    bias: float
    """Mean error of bit torque, N·m."""
    speed_within: float
    """Share of speed errors within two stated standard deviations; NaN where none are stated."""
    torque_within: float
    """The same of torque."""


def answer(told: Columns, kind: str) -> Answer:
    """Confirmed, now or forecast, from an estimates table."""
    when = told["time_s"] if kind == "now" else told[f"{kind}_time_s"]
    names = ("speed_rad_s", "speed_std_rad_s", "torque_nm", "torque_std_nm")
    return Answer(when, *(told[f"{kind}_{name}"] for name in names))


def surface_speed(surface: Columns) -> Answer:
    """What a driller sees today, taken for the bit; it says nothing of torque, nor of its own error."""
    silent = np.full_like(surface["time_s"], np.nan)
    return Answer(surface["time_s"], surface["motor_speed_rad_s"], silent, silent, silent)


def score(told: Answer, truth: Columns, from_s: float) -> Score:
    """Score an answer from `from_s` to the end of the truth."""
    use = np.isfinite(told.speed) & (told.time >= from_s) & (told.time <= truth["time_s"][-1])
    when, speed, speed_std, torque, torque_std = (column[use] for column in told)
    speed_error = speed - np.interp(when, truth["time_s"], truth["bit_speed_rad_s"])
    torque_error = torque - np.interp(when, truth["time_s"], truth["bit_torque_nm"])
    return Score(
        speed=rms(speed_error),
        share=rms(speed_error) / span(truth, from_s),
        torque=rms(torque_error),
        bias=float(np.mean(torque_error)),
        speed_within=_within(speed_error, speed_std),
        torque_within=_within(torque_error, torque_std),
    )


def rms(error: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(error**2)))


def span(truth: Columns, from_s: float) -> float:
    """Range of the true bit speed, rad/s."""
    return float(np.ptp(truth["bit_speed_rad_s"][truth["time_s"] >= from_s]))


def _within(error: Floats, std: Floats) -> float:
    stated = std > 0
    return float(np.mean(np.abs(error[stated]) <= 2 * std[stated])) if stated.any() else np.nan
