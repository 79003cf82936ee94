"""The configuration corrected by the record itself: the string's delay and impedance, top-drive inertia, wall
friction, torque's zero.

Beside the model string run shadows of it, a pair for each of the first three: with more of it and with less.
What their answers differ by tells what an uncertain parameter costs the answer (doubt.py). Whose innovations
are smallest is nearest to the truth: so delay and impedance are found (misfit.py). The others cannot be told
while there is a rock, which innovations lay everything to. Off bottom there is none, and a tare tells them
(tare.py).
"""

from typing import NamedTuple

import numpy as np

from vsensor.config import Tuning as Settings
from vsensor.estimator.sections import Floats, Integers, Line, stretched
from vsensor.jit import compiled

DELAY, IMPEDANCE, INERTIA, FRICTION, OFFSET = range(5)
PARAMETERS = 5
HEARD = slice(DELAY, INERTIA)
"""Those that innovations tell,"""
TARED = slice(INERTIA, PARAMETERS)
"""and those that a tare tells."""
SHADOWED = 3
"""Delay, impedance and inertia have shadows, a pair each: more of it, and less."""
LATER, SOONER = 1 + 2 * SHADOWED, 2 + 2 * SHADOWED
"""Two more have a bit that breaks loose later, or sooner (rise.py)."""
OFF, ON = range(2)
"""The wall is told of by a bit that is told to be off bottom, and bounded by one that is not (tare.py)."""
STRINGS = 3 + 2 * SHADOWED
"""The model string, and then its shadows, in that order."""
BOUND = 3.0
"""No correction goes beyond so many of the stated deviations."""
EVERY_S = 5.0
"""How often a correction is made,"""
SURELY = 2.0
"""and only where it exceeds so many of its own deviations."""


Matrix = list[list[float]]


class Tuning(NamedTuple):
    """What is known of the parameters: shares of what is configured, and the torque's offset in N·m."""

    prior: Floats
    """Variance of each before the record said anything, shape (5,)."""
    value: Floats
    """The corrections in force, shape (5,)."""
    variance: Floats
    """Mean square of what they may still be wrong by, shape (5,)."""
    shared: Floats
    """The same of friction times offset, N·m, shape (1,)."""
    misfit: Floats
    """Sums of squared innovations: the model's, those with more and less delay, with more and less impedance,
    shape (5,);"""
    crossed: Floats
    """and of what the first pair differs by times what the second does, shape (1,)."""
    information: Floats
    """What a bit OFF and ON bottom told of inertia, friction and offset: sums of products of what each does
    to the torque, shape (2, 3, 3),"""
    pulls: Floats
    """and of that times the torque left over, shape (2, 3): OFF each weighted by how well it was known;"""
    doubt: Floats
    """ON all alike, by the variance of the newest torque, shape (1,): for the rock is not yet told to be more
    restless when its torque begins to differ."""
    asked: Floats
    """By what ON bottom friction was to change when it was last looked at, shape (1,)."""
    steady: Integers
    """Ticks for which the string has turned as one, shape (2,)."""
    too_low: Integers
    """Whether it does under less torque than any friction asks for that is within its bounds, shape (1,)."""


def shadows(p: int) -> slice:
    """Which of the strings are the shadows of one of the first parameters."""
    return slice(1 + 2 * p, 3 + 2 * p)


def fresh_tuning(settings: Settings, passed: float) -> Tuning:
    """Nothing told yet: what the configuration says of its own error. Gear and drive make 1 N·m `passed`."""
    shares = settings.delay, settings.impedance, settings.inertia, settings.friction
    prior = np.array([*shares, settings.torque_offset * passed]) ** 2
    return Tuning(
        prior=prior,
        value=np.zeros(PARAMETERS),
        variance=prior.copy(),
        shared=np.zeros(1),
        misfit=np.zeros(5),
        crossed=np.zeros(1),
        information=np.zeros((2, 3, 3)),
        pulls=np.zeros((2, 3)),
        doubt=np.ones(1),
        asked=np.zeros(1),
        steady=np.zeros(2, np.int64),
        too_low=np.zeros(1, np.int64),
    )


def bounded(tuning: Tuning, p: int, due: float) -> float:
    """As much of a correction as leaves a parameter within its bounds."""
    value, bound = float(tuning.value[p]), BOUND * float(tuning.prior[p]) ** 0.5
    return float(min(max(due, -bound - value), bound - value))


def posterior(prior: list[float], information: Matrix) -> Matrix:
    """(P⁻¹ + A)⁻¹ of prior variances P and information A; what has no prior variance has none afterwards.

    As D (1 + D A D)⁻¹ D with D² = P, by elimination: a library's last bits differ from machine to machine.
    """
    n, d = len(prior), [variance**0.5 for variance in prior]
    rows = [
        [(i == j) + d[i] * information[i][j] * d[j] for j in range(n)] + [float(i == j) for j in range(n)]
        for i in range(n)
    ]
    for i, row in enumerate(rows):
        row[:] = [value / row[i] for value in row]
        for other in rows[:i] + rows[i + 1 :]:
            other[:] = [a - other[i] * b for a, b in zip(other, row, strict=True)]
    return [[d[i] * rows[i][n + j] * d[j] for j in range(n)] for i in range(n)]


def tuned(line: Line, value: Floats) -> Line:
    """The line with delay, impedance and friction corrected."""
    rough, line = 1 + value[FRICTION], stretched(line, float(value[DELAY]))
    return line._replace(
        impedance=line.impedance * (1 + value[IMPEDANCE]),
        viscous=line.viscous * rough,
        kinetic=line.kinetic * rough,
        static=line.static * rough,
    )


@compiled
def wall_torque(line: Line, tuning: Tuning, speed: float) -> float:
    """Friction along the whole string, N·m, while all of it turns at `speed`: as configured, of which

    a correction is a share, not as the corrected `line` has it.
    """
    sign = 1.0 if speed > 0 else -1.0 if speed < 0 else 0.0
    corrected = line.viscous.sum() * speed + line.kinetic.sum() * sign
    return float(corrected / (1.0 + tuning.value[FRICTION]))
