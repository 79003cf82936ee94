"""What each component of the string bears in torsion."""

import math
from typing import NamedTuple

from vsensor.config import Component


class Limit(NamedTuple):
    """The torque that a component bears, N·m, and what sets it."""

    torque: float
    by: str


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
