"""A session's estimates as the report takes them: columns of numbers, a piece of the session at a time."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vsensor.recording.columns import Columns

Floats = npt.NDArray[np.float64]
Times = npt.NDArray[np.int64]

BIT, TOP = "confirmed_bit_speed_rad_s", "top_speed_rad_s"
BIT_TORQUE, TOP_TORQUE = "confirmed_bit_torque_nm", "top_torque_nm"

FIELDS = (
    "time_ns",
    "confirmed_time_ns",
    "forecast_time_ns",
    BIT,
    BIT_TORQUE,
    "now_bit_speed_rad_s",
    "now_bit_torque_nm",
    "forecast_bit_speed_rad_s",
    "forecast_bit_torque_nm",
    TOP,
    TOP_TORQUE,
    "quality",
)
"""What the report reads of each estimate."""


@dataclass(frozen=True)
class Ticks:
    """n estimates. Times in ns, all else SI, NaN where not known."""

    time_ns: Times
    """Of each tick,"""
    confirmed_ns: Times
    """the time for which its confirmed answer is (the tick's own where there is none),"""
    forecast_ns: Times
    """and the time of its forecast, likewise."""
    columns: Mapping[str, Floats]
    """Numbers of each estimate by the field's name."""

    def __len__(self) -> int:
        return len(self.time_ns)

    def __getitem__(self, name: str) -> Floats:
        return self.columns[name]

    def of(self, chosen: npt.NDArray[np.bool_]) -> "Ticks":
        """Those that are chosen."""
        columns = {name: values[chosen] for name, values in self.columns.items()}
        return Ticks(self.time_ns[chosen], self.confirmed_ns[chosen], self.forecast_ns[chosen], columns)


def ticks_of(estimates: Columns) -> Ticks:
    """The ticks of a piece of a session, of which `FIELDS` were read."""

    def at(name: str) -> Times:
        return np.where(estimates.known[name], estimates.values[name], estimates.values["time_ns"])

    columns = {name: estimates.number(name) for name in FIELDS if not name.endswith("_ns")}
    return Ticks(at("time_ns"), at("confirmed_time_ns"), at("forecast_time_ns"), columns)


def joined(pieces: list[Ticks]) -> Ticks:
    """Pieces, at least one, as one."""
    columns = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0].columns}
    time, confirmed, forecast = (
        np.concatenate(each)
        for each in zip(*((p.time_ns, p.confirmed_ns, p.forecast_ns) for p in pieces), strict=True)
    )
    return Ticks(time, confirmed, forecast, columns)
