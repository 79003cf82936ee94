"""A session gathered for the report: estimates as columns, the string's worst, what was told beside."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from vsensor.errors import InputError
from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    SENSOR_TICK,
    STRING_PROFILE,
    Event,
    Status,
)
from vsensor.recording.columns import Columns, read_columns
from vsensor.recording.reader import Session
from vsensor.report.grown import Grown

Floats = npt.NDArray[np.float64]

_ESTIMATE = (
    "time_ns",
    "confirmed_time_ns",
    "confirmed_bit_speed_rad_s",
    "confirmed_bit_torque_nm",
    "now_bit_speed_rad_s",
    "now_bit_torque_nm",
    "forecast_time_ns",
    "forecast_bit_speed_rad_s",
    "forecast_bit_torque_nm",
    "top_speed_rad_s",
    "top_torque_nm",
    "quality",
)
_PROFILE = ("depth_m", "shear_stress_pa", "torque_nm", "torque_limit_nm", "margin")


@dataclass
class Along:
    """The string's worst at each of n stations, SI; what is not known is NaN."""

    depth_m: Floats
    stress_pa: Floats
    """The greatest shear stress, whichever way,"""
    torque_nm: Floats
    """and torque."""
    limit_nm: Floats
    margin: Floats
    """The least: 0 at the limit."""

    def take(self, other: "Along") -> "Along":
        """The worst of both; where the string has other stations by now, the later ones alone."""
        if len(self.depth_m) != len(other.depth_m) or not np.allclose(self.depth_m, other.depth_m):
            return other
        return Along(
            self.depth_m,
            np.fmax(self.stress_pa, other.stress_pa),
            np.fmax(self.torque_nm, other.torque_nm),
            other.limit_nm,
            np.fmin(self.margin, other.margin),
        )


@dataclass
class Story:
    """What a session tells. Times in ns, all else SI, NaN where not known; n ticks."""

    columns: Mapping[str, Floats]
    """Numbers of each estimate by the field's name."""
    time_ns: npt.NDArray[np.int64]
    """Of each tick,"""
    confirmed_ns: npt.NDArray[np.int64]
    """the time for which its confirmed answer is (the tick's own where there is none),"""
    forecast_ns: npt.NDArray[np.int64]
    """and the time of its forecast, likewise."""
    lateness_s: Floats
    """How late the loop woke for each tick."""
    statuses: list[Status] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    along: Along | None = None

    def __getitem__(self, name: str) -> Floats:
        return self.columns[name]

    @property
    def status(self) -> Status | None:
        """The last one."""
        return self.statuses[-1] if self.statuses else None


def gather(session: Session) -> Story:
    """Read a session once. Raises InputError where it holds no estimates."""
    wanted = {BIT_ESTIMATE: _ESTIMATE, SENSOR_TICK: ("lateness_ns",), STRING_PROFILE: _PROFILE}
    estimates = {name: Grown(np.int64 if name.endswith("_ns") else np.float64) for name in _ESTIMATE}
    late = Grown(np.float64)
    statuses: list[Status] = []
    events: list[Event] = []
    along: Along | None = None
    for piece in read_columns(session, wanted, whole=(SENSOR_STATUS, SENSOR_EVENT)):
        if BIT_ESTIMATE in piece:
            for name, column in estimates.items():
                column.add(_column(piece[BIT_ESTIMATE], name))
        if SENSOR_TICK in piece:
            lateness = piece[SENSOR_TICK]
            late.add(lateness.values["lateness_ns"][lateness.known["lateness_ns"]] / 1e9)
        if STRING_PROFILE in piece:
            worst = _worst(piece[STRING_PROFILE])
            along = worst if along is None else along.take(worst)
        messages = [message for columns in piece.values() for message in columns.messages]
        statuses += [message for message in messages if isinstance(message, Status)]
        events += [message for message in messages if isinstance(message, Event)]
    if not len(estimates["time_ns"]):
        raise InputError(
            f"{session.path}: holds no {BIT_ESTIMATE} to report on; they can be made of its samples by: "
            f"vsensor estimate {session.path} RIG.toml -o WITH_ESTIMATES.mcap"
        )
    columns = {name: column.whole() for name, column in estimates.items()}
    return Story(
        time_ns=columns.pop("time_ns"),
        confirmed_ns=columns.pop("confirmed_time_ns"),
        forecast_ns=columns.pop("forecast_time_ns"),
        columns=columns,
        lateness_s=late.whole(),
        statuses=statuses,
        events=events,
        along=along,
    )


def _column(estimates: Columns, name: str) -> npt.NDArray[Any]:
    """A field as doubles, or a time in ns: the tick's own where there is no other."""
    if name.endswith("_ns"):
        return np.where(estimates.known[name], estimates.values[name], estimates.values["time_ns"])
    return estimates.number(name)


def _worst(profiles: Columns) -> Along:
    """The worst of some profiles; of those with other stations than the last, nothing."""
    depth = profiles.values["depth_m"]
    alike = np.all((depth == depth[-1]) | (np.isnan(depth) & np.isnan(depth[-1])), axis=1)
    known = ~np.isnan(depth[-1])

    def of(name: str) -> Floats:
        return np.asarray(profiles.values[name][alike][:, known])

    return Along(
        depth[-1][known],
        np.abs(of("shear_stress_pa")).max(axis=0),
        np.abs(of("torque_nm")).max(axis=0),
        of("torque_limit_nm")[-1],
        of("margin").min(axis=0),
    )
