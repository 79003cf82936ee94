"""What comes of the samples: one tick's input."""

from typing import NamedTuple


class Input(NamedTuple):
    """What the estimator is given at one tick."""

    number: int
    """Ticks since the grid was last laid; 0 means that the estimator must forget all input."""
    time_ns: int
    motor_torque: float
    motor_speed: float
    reasons: int
    """Flags of `Reason`."""
    off_bottom: bool = False
    longer_by: float = 0.0
    """By how much the string has become longer since the tick before, m."""
    forecast_shed: bool = False
    """Nothing is to be foretold: the loop is short of time."""
