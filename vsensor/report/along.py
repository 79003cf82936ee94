"""The string's worst at each place along it."""

from dataclasses import dataclass

import numpy as np

from vsensor.recording.columns import Columns
from vsensor.report.ticks import Floats

PROFILE = ("depth_m", "shear_stress_pa", "torque_nm", "torque_limit_nm", "margin")
"""What the report reads of each profile."""


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


def worst(profiles: Columns) -> Along:
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
