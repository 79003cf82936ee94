"""The bit's speed and torque out of an estimate, in the units that people read."""

import math
from dataclasses import dataclass
from typing import Literal

from vsensor.messages import Estimate
from vsensor.view.units import Units

Kind = Literal["confirmed", "now", "forecast"]
KINDS: tuple[Kind, ...] = ("confirmed", "now", "forecast")


@dataclass(frozen=True, slots=True)
class Reading:
    """One answer: when (source clock, ns) and what, with standard deviations; or NaN."""

    time_ns: int
    speed: float
    speed_std: float
    torque: float
    torque_std: float


def reading(estimate: Estimate, kind: Kind, units: Units) -> Reading:
    """The confirmed, now or forecast answer in these units; NaN for what is not known."""

    def known(field: str, scale: float) -> float:
        return getattr(estimate, field) * scale if _has(estimate, field) else math.nan

    return Reading(
        estimate.time_ns if kind == "now" else getattr(estimate, f"{kind}_time_ns"),
        known(f"{kind}_bit_speed_rad_s", units.speed_factor),
        known(f"{kind}_bit_speed_std_rad_s", units.speed_factor),
        known(f"{kind}_bit_torque_nm", units.torque_factor),
        known(f"{kind}_bit_torque_std_nm", units.torque_factor),
    )


def _has(estimate: Estimate, field: str) -> bool:
    return estimate.HasField(field)  # type: ignore[arg-type]  # the stub lists the names one by one
