"""What hangs on each depth of the string, down any well."""

from collections.abc import Sequence

import numpy as np

from vsensor.config import Component
from vsensor.config.well import Station, Wellbore
from vsensor.estimator.component import buoyed_weight
from vsensor.estimator.wellpath import Floats, Path, vertical_depth, well_path


def greatest_tension(
    string: Sequence[Component], depths: Floats, survey: Sequence[Station], wellbore: Wellbore | None
) -> Floats:
    """The greatest pull or push while it turns, N, at depths (m along the string, shape (n,)).

    Off bottom it is pulled most, but what lies flat is pushed by the weight on bit (negative). Where no well
    is told it is taken to be straight down and empty, which is on the safe side.
    """
    if wellbore is None:
        return hanging_weight(string, depths)
    pulled = hanging_weight(string, depths, wellbore.mud_density, well_path(survey))
    on_bottom = pulled - wellbore.weight_on_bit
    return np.where(np.abs(on_bottom) > np.abs(pulled), on_bottom, pulled)


def hanging_weight(
    string: Sequence[Component], depths: Floats, mud_density: float = 0.0, path: Path | None = None
) -> Floats:
    """What hangs below depths (m along the string, shape (n,)), N: weight per metre by the vertical way.

    Buoyed by mud of a density in kg/m³ (0: in air) as by API RP 7G's buoyancy factor. Without a path the
    well is vertical. Without drag: a string that turns slides around the hole, and not along it.
    """
    ends = np.cumsum([0.0, *(part.length for part in string)])
    weight = np.array([buoyed_weight(part, mud_density) for part in string])
    bottoms, at = (each if path is None else vertical_depth(path, each) for each in (ends, depths))
    below = np.append(np.cumsum((weight * np.diff(bottoms))[::-1])[::-1], 0.0)
    part = np.searchsorted(ends[1:-1], depths, side="right")
    return np.asarray(below[part + 1] + weight[part] * (bottoms[part + 1] - at))
