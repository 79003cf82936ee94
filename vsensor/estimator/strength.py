"""What each component of the string bears in torsion, and what hangs on it."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vsensor.config import Component
from vsensor.estimator.component import buoyed_weight
from vsensor.estimator.sections import Floats


class Limit(NamedTuple):
    """The torque that a component bears, N·m, and what sets it."""

    torque: float
    by: str


def hanging_weight(
    string: Sequence[Component], depths: Floats, mud_density: float = 0.0, weight_on_bit: float = 0.0
) -> Floats:
    """Tension of a vertical string at depths (m along it), N: what hangs below, less what stands on the bit.

    Buoyed by mud of a density in kg/m³ (0: in air) as by API RP 7G's buoyancy factor; without the wall's
    drag. Below the neutral point it is negative: the string is pressed.
    """
    bounds = np.cumsum([0.0, *(part.length for part in string)])
    weights = [buoyed_weight(part, mud_density) * part.length for part in string]
    above = np.interp(depths, bounds, np.cumsum([0.0, *weights]))
    return np.asarray(sum(weights) - above - weight_on_bit)


def torsional_limit(part: Component, tension: float = 0.0) -> Limit | None:
    """The least of a component's limits in torsion under a tension (N); None where none is given.

    A connection must not see more than the torque it was made up with. A pipe body yields where
    torsion and tension together do (API RP 7G, combined torsion and tension; von Mises):

        T = T_max √(1 − (F/F_max)²)
    """
    limits = []
    if part.torsional_strength is not None:
        limits.append(_body(part, part.torsional_strength, tension))
    if part.make_up_torque is not None:
        limits.append(Limit(part.make_up_torque, "make-up torque"))
    return min(limits, default=None)


def _body(part: Component, strength: float, tension: float) -> Limit:
    if part.tensile_strength is None:
        return Limit(strength, "torsional strength")
    left = max(0.0, 1 - (tension / part.tensile_strength) ** 2)
    return Limit(strength * math.sqrt(left), "torsional strength under tension")
