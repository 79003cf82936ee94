"""What the string is and how it lies, as a message: what a view needs to draw a profile."""

import time
from collections.abc import Sequence

import numpy as np

from vsensor.config import Component, Rig
from vsensor.config.well import Station
from vsensor.estimator import component
from vsensor.estimator.along import station_depths
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.modes import torsional_modes
from vsensor.estimator.sections import Floats
from vsensor.estimator.wellpath import place, well_path
from vsensor.messages import Description

EVERY_S = 10
"""A view that comes later waits no longer than so many seconds for the next one."""
MODES = 12
"""Enough to reach 5 Hz on 3 km of string."""


class Describer:
    """Describes one rig's string again and again, at once where it has become another."""

    def __init__(self, rig: Rig, estimator: Estimator) -> None:
        self._rig = rig
        self._estimator = estimator
        self._string = estimator.string
        self._described = describe(rig, self._string)
        self._seconds = 0

    def second(self) -> Description | None:
        """Count a second; the description where one is due."""
        changed = self._string is not self._estimator.string
        if changed:
            self._string = self._estimator.string
            self._described = describe(self._rig, self._string)
        due = changed or self._seconds % EVERY_S == 0
        self._seconds += 1
        if not due:
            return None
        self._described.time_ns = time.time_ns()
        return self._described


def describe(rig: Rig, string: Sequence[Component]) -> Description:
    """This string, which may have become longer than the rig's was, in the rig's well."""
    depth, component_of, _ = station_depths(string)
    parts = [string[number] for number in component_of]
    north, east, down = _places(rig.survey, depth).T.tolist()
    return Description(
        time_ns=time.time_ns(),
        depth_m=depth.tolist(),
        north_m=north,
        east_m=east,
        vertical_depth_m=down,
        impedance_nm_s_rad=[component.impedance(part) for part in parts],
        compliance_rad_nm_m=[_compliance(part) for part in parts],
        component=[part.name for part in string],
        component_end_m=np.cumsum([part.length for part in string]).tolist(),
        mode_hz=torsional_modes(string, rig.bit.inertia, MODES).tolist(),
        gear_ratio=rig.top_drive.gear_ratio,
        efficiency=rig.top_drive.efficiency,
    )


def _places(survey: Sequence[Station], depth: Floats) -> Floats:
    """North, east and down of the well's top; straight down where there is no survey; shape (n, 3)."""
    if survey:
        return place(well_path(survey), depth)
    return np.stack([np.zeros_like(depth), np.zeros_like(depth), depth], axis=1)


def _compliance(part: Component) -> float:
    return 1 / (part.shear_modulus * component.polar_moment(part))
