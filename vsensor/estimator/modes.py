"""The natural frequencies of a lossless string, every one of them, in order.

In a steady swing at angular frequency Ω, twist and torque along a uniform component are
A sin φ and ΩζA cos φ, and the phase φ grows by Ωθ from its top to its bottom: the paper's line
matrix (eq. 12-17) with w = j cot Ωθ, written as an angle (Prüfer's). At a change of section twist
and torque go through, so tan φ scales with ζ and φ stays in its quadrant. The phase that arrives at the
bit therefore only ever grows with Ω, while the phase that the bit asks for, arccot(ΩJ/ζ), only
falls: each mode is the one crossing of its multiple of π, and bisection cannot miss it.
"""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Component
from vsensor.estimator import component

Floats = NDArray[np.float64]

_HALVINGS = 80  # of a bracket that is a few hundred modes wide at most: down to the last bit of a float


def torsional_modes(
    components: Sequence[Component], bit_inertia: float, count: int, top: Literal["held", "free"] = "held"
) -> Floats:
    """The lowest `count` torsional natural frequencies in Hz, ascending, shape (count,).

    `components` from the top down; `bit_inertia` in kg·m² at the lower end. A held top is the stiff top
    drive that stick-slip sees; with a free top the whole string's even turning, at 0 Hz, is left out.
    """
    impedances = np.array([component.impedance(part) for part in components])
    delays = np.array([component.delay(part) for part in components])
    start = 0.0 if top == "held" else math.pi / 2
    turns = math.pi * np.arange(count) if top == "held" else math.pi * np.arange(1, count + 1)

    def excess(omega: Floats) -> Floats:
        asked: Floats = np.arctan2(impedances[-1], omega * bit_inertia) + turns
        return _phase_at_bit(omega, start, impedances, delays) - asked

    # Each change of section holds the phase back by less than π/2, and so does the bit.
    low: Floats = np.zeros(count)
    high: Floats = (turns + math.pi / 2 * (len(impedances) + 1)) / delays.sum()
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        below = excess(middle) < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return (low + high) / (4 * math.pi)


def _phase_at_bit(omega: Floats, start: float, impedances: Floats, delays: Floats) -> Floats:
    """The phase that has run up from the top, for each Ω; shape of `omega`."""
    phase = np.full_like(omega, start)
    above = impedances[0]
    for here, delay in zip(impedances, delays, strict=True):
        ratio = here / above
        sine, cosine = np.sin(phase), np.cos(phase)
        # tan φ′ = … : twist A sin φ and torque ζA cos φ are both continuous
        phase = phase + np.arctan2((ratio - 1) * sine * cosine, cosine**2 + ratio * sine**2) + omega * delay
        above = here
    return phase
