"""Samples of the two channels, late, lost or doubled, onto the tick's grid."""

from vsensor.intake.channel import FARTHEST_NS
from vsensor.intake.given import Input
from vsensor.intake.intake import FORECAST_SHED, OBEYED, Intake

__all__ = ["FARTHEST_NS", "FORECAST_SHED", "OBEYED", "Input", "Intake"]
