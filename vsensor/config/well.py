"""The well as a configuration tells it: stations of a survey, and what presses the string on the wall."""

import math
from itertools import pairwise
from typing import Self

from pydantic import Field, model_validator

from vsensor.config.schema import Azimuth, Density, Depth, Force, FrictionFactor, Inclination, Table

TURNED_BACK = 1e-9
"""Directions whose cosine is so near to −1 leave open in which plane the well turns round."""


class Station(Table):
    """One station of the survey. The azimuth is told from north, clockwise as seen from above."""

    measured_depth: Depth = Field(description='a length along the well, such as "1200 m"')
    inclination: Inclination = Field(description='an angle from "0 deg" to "180 deg", such as "31.5 deg"')
    azimuth: Azimuth = Field(description='an angle from "-360 deg" to "360 deg", such as "140 deg"')


class Wellbore(Table):
    """What presses the string on the wall of a surveyed well, and how the wall rubs."""

    mud_density: Density = Field(description='a density such as "1.2 g/cm^3"')
    friction_factor: FrictionFactor = Field(description="a kinetic friction factor, such as 0.25")
    static_friction_factor: FrictionFactor = Field(default_factory=lambda given: given["friction_factor"])
    weight_on_bit: Force = 0.0

    @model_validator(mode="after")
    def _static_holds_more(self) -> Self:
        if self.static_friction_factor < self.friction_factor:
            raise ValueError(
                f"static_friction_factor {self.static_friction_factor:g} must be at least "
                f"friction_factor (kinetic) {self.friction_factor:g}"
            )
        return self


def from_surface(survey: tuple[Station, ...]) -> tuple[Station, ...]:
    """The stations from surface down; where they begin deeper, tied on to a well that sets out straight down.

    Raises ValueError where they make no path.
    """
    if len(survey) == 1:
        raise ValueError("one station makes no path: write two or more [[survey]] tables")
    if survey and survey[0].measured_depth > 0:
        survey = (Station(measured_depth=0, inclination=0, azimuth=survey[0].azimuth), *survey)
    for above, below in pairwise(survey):
        if below.measured_depth <= above.measured_depth:
            raise ValueError(
                f"the station at {below.measured_depth:g} m must be deeper than the one before it, "
                f"at {above.measured_depth:g} m"
            )
        if _cosine(above, below) < TURNED_BACK - 1:
            raise ValueError(
                f"the well points the other way at {below.measured_depth:g} m than at "
                f"{above.measured_depth:g} m: no one arc leads there: write a station between them"
            )
    return survey


def _cosine(one: Station, other: Station) -> float:
    """Cosine of the angle between the directions of two stations."""
    down = math.cos(one.inclination) * math.cos(other.inclination)
    aside = math.sin(one.inclination) * math.sin(other.inclination)
    return down + aside * math.cos(other.azimuth - one.azimuth)
