"""The units in which the view tells speeds and torques."""

from dataclasses import dataclass

from vsensor.config import SpeedUnit, TorqueUnit
from vsensor.units import factor


@dataclass(frozen=True, slots=True)
class Units:
    """As configured or asked for; written as people write them."""

    speed_unit: SpeedUnit = "rpm"
    torque_unit: TorqueUnit = "kN*m"

    @property
    def speed(self) -> str:
        """The unit of speed in print."""
        return self.speed_unit

    @property
    def torque(self) -> str:
        """The unit of torque in print."""
        return self.torque_unit.replace("*", "·")

    @property
    def speed_factor(self) -> float:
        """How many of it make one rad/s."""
        return factor("rad/s", self.speed_unit)

    @property
    def torque_factor(self) -> float:
        """How many of it make one N·m."""
        return factor("N*m", self.torque_unit)

    def speed_text(self, value: float) -> str:
        """A speed in as many digits as are told by a sensor that is good to 1 rpm."""
        return f"{value:.{0 if self.speed_unit == 'rpm' else 1}f}".replace("-", "−")

    def torque_text(self, value: float) -> str:
        """A torque in as many digits as are told by a sensor that is good to 100 N·m."""
        return f"{value:.{0 if self.torque_unit == 'N*m' else 1}f}".replace("-", "−")
