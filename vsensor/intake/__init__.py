"""Samples of the two channels, late, lost or doubled, onto the tick's grid."""

from vsensor.intake.intake import FARTHEST_NS, FORECAST_SHED, OBEYED, Input, Intake

__all__ = ["FARTHEST_NS", "FORECAST_SHED", "OBEYED", "Input", "Intake"]
