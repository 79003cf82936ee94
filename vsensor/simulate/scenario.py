"""What the simulated driller does: surface speed over time, and what the bit meets meanwhile."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from vsensor.config import Bit
from vsensor.estimator.sections import Floats


class Scenario(StrEnum):
    """The scenarios by name."""

    STICK_SLIP = "stick-slip"
    SMOOTH = "smooth"
    OFF_BOTTOM = "off-bottom"
    CONNECTION = "connection"


@dataclass(frozen=True)
class Plan:
    """A scenario: breakpoints of surface speed, share of the load law on the bit, and the controller."""

    speed: tuple[tuple[float, float], ...]
    """(s, rad/s), straight lines between, the last value kept."""
    load: tuple[tuple[float, float], ...]
    """(s, share of the configured load law), straight lines between."""
    damping: float
    """Proportional gain of the speed controller in impedances of the string: 1 swallows the waves
    that arrive, a high gain reflects them (soft torque, Kyllingstad and Nessjøen 2009)."""
    rock_noise: float
    """Standard deviation of the rock's torque as a share of the kinetic torque."""

    def speed_at(self, time_s: Floats) -> Floats:
        """Commanded string speed, rad/s, at times of shape (n,), s."""
        times, speeds = zip(*self.speed, strict=True)
        return np.asarray(np.interp(time_s, times, speeds))

    def bit_at(self, bit: Bit, time_s: float) -> Bit:
        """The load law at a time."""
        times, shares = zip(*self.load, strict=True)
        share = float(np.interp(time_s, times, shares))
        return bit.model_copy(
            update={
                "viscous_friction": share * bit.viscous_friction,
                "kinetic_torque": share * bit.kinetic_torque,
                "static_torque": share * bit.static_torque,
            }
        )


ON_BOTTOM = ((0.0, 1.0),)

PLANS = {
    Scenario.STICK_SLIP: Plan(((0, 0), (5, 8), (50, 8), (55, 13)), ON_BOTTOM, 50.0, 0.05),
    Scenario.SMOOTH: Plan(((0, 0), (8, 18)), ON_BOTTOM, 1.0, 0.15),
    Scenario.OFF_BOTTOM: Plan(((0, 0), (3, 0), (6, 6.3), (45, 6.3), (50, 12.5)), ((0.0, 0.0),), 15.0, 0.0),
    Scenario.CONNECTION: Plan(
        ((0, 0), (8, 12), (30, 12), (34, 0), (60, 0), (66, 12)),
        ((0, 0), (12, 0), (15, 1), (25, 1), (28, 0), (72, 0), (76, 1)),
        4.0,
        0.1,
    ),
}
