"""The configuration corrected by the record itself: delay, top-drive inertia, wall friction.

Beside the model string run shadows of it: with longer delays and with shorter ones, with more inertia and
with less. Whose innovations are smallest is nearest to the truth, and a parabola through the three sums of
squares of a parameter tells where it lies and how surely (maximum likelihood, Ljung 1999, chapter 7). What
the shadows' answers differ by tells what an uncertain parameter costs the answer.

Friction cannot be told from the bit's torque while there is any. Off bottom there is none, and what is left
over of the bit's torque is the wall's: a tare.
"""

from typing import NamedTuple

import numpy as np

from vsensor.config import Tuning as Settings
from vsensor.estimator.sections import Floats, Integers, Line, stretched
from vsensor.jit import compiled

DELAY, INERTIA, FRICTION = range(3)
PARAMETERS = 3
SHADOWED = 2
"""Delay and inertia are told by shadows, a pair each: more of it, and less."""
STRINGS = 1 + 2 * SHADOWED
"""The model string, and then its shadows: longer delays, shorter ones, more inertia, less."""
BOUND = 3.0
"""No correction goes beyond so many of the stated deviations."""
EVERY_S = 5.0
"""How often a correction is made,"""
SURELY = 2.0
"""and only where it exceeds so many of its own deviations."""
MEMORY_S = 300.0
"""Time over which the record is forgotten."""
WORTH = 0.05
"""The model is not the string: what innovations tell of a parameter counts for a twentieth."""
SETTLED_S = 60.0
"""Not before the load law was learned for as long as it remembers: its errors would be laid to the string."""
TARE_S = 30.0
"""Time over which a tare is forgotten."""
APART_S = 1.0
"""Bit torques so far apart tell independently of friction."""


class Tuning(NamedTuple):
    """What is known of the parameters, each as a share of what is configured."""

    prior: Floats
    """Variance of each before the record said anything, shape (3,)."""
    value: Floats
    """The corrections in force, shape (3,)."""
    variance: Floats
    """Of what is still uncertain, shape (3,)."""
    misfit: Floats
    """Sums of squared innovations in force, with more and with less of each parameter, shape (2, 3)."""
    tare: Floats
    """What off bottom was told of friction: information, and where it pulls, shape (2,)."""
    steady: Integers
    """Ticks for which the string has turned steadily off bottom, shape (1,)."""


def fresh_tuning(settings: Settings) -> Tuning:
    """Nothing told yet: what the configuration says of its own error."""
    prior = np.array([settings.delay, settings.inertia, settings.friction]) ** 2
    return Tuning(
        prior=prior,
        value=np.zeros(PARAMETERS),
        variance=prior.copy(),
        misfit=np.zeros((SHADOWED, 3)),
        tare=np.zeros(2),
        steady=np.zeros(1, np.int64),
    )


def correct(tuning: Tuning, off: Floats, enabled: bool) -> bool:
    """Take up the corrections that are due; whether there were any. `off` (2,) is what shadows are off by."""
    changed = False
    for p in range(PARAMETERS):
        information, pull = _parabola(tuning, p, float(off[p])) if p < SHADOWED else tuning.tare.tolist()
        variance = 1 / (information + 1 / float(tuning.prior[p]))
        tuning.variance[p] = variance
        due = variance * pull
        bound = BOUND * float(tuning.prior[p]) ** 0.5
        due = min(max(due, -bound - float(tuning.value[p])), bound - float(tuning.value[p]))
        if enabled and due * due > SURELY**2 * variance:
            changed = True
            _take(tuning, p, due, float(off[p]) if p < SHADOWED else 0.0)
    return changed


def _parabola(tuning: Tuning, p: int, off: float) -> tuple[float, float]:
    """Information on a correction, and where it pulls: of the parabola through three misfits."""
    here, more, less = tuning.misfit[p].tolist()
    information = WORTH * (more - 2 * here + less) / (2 * off * off)
    pull = WORTH * (less - more) / (4 * off)
    # Far from the truth the valley has no floor yet: its side tells the way, and that it is far.
    return max(information, abs(pull) / (2 * off)), pull


def _take(tuning: Tuning, p: int, due: float, off: float) -> None:
    """Move; no further than the shadows were, for there they must look anew."""
    if p < SHADOWED:
        tuning.value[p] += min(max(due, -off), off)
        tuning.misfit[:] = 0.0
    else:
        tuning.value[p] += due
        # Pairs of before the correction are still on their way.
        tuning.tare[1] = 0.0
        tuning.steady[0] = 0


def tuned(line: Line, value: Floats) -> Line:
    """The line with delay and friction corrected."""
    rough = 1 + value[FRICTION]
    return stretched(line, float(value[DELAY]))._replace(
        viscous=line.viscous * rough, kinetic=line.kinetic * rough, static=line.static * rough
    )


@compiled
def weigh_tare(tuning: Tuning, wall: float, torque: float, doubt: float, rate: float) -> None:
    """Learn from a bit torque that is truly zero, known with the variance `doubt`; the wall takes `wall`."""
    weight = 1.0 / (APART_S * rate * doubt)
    keep = 1.0 - 1.0 / (TARE_S * rate)
    tuning.tare[0] = keep * tuning.tare[0] + weight * wall * wall
    tuning.tare[1] = keep * tuning.tare[1] + weight * wall * torque


@compiled
def wall_torque(line: Line, speed: float) -> float:
    """Friction along the whole string, N·m, while all of it turns at `speed`."""
    sign = 1.0 if speed > 0 else -1.0 if speed < 0 else 0.0
    return float(line.viscous.sum() * speed + line.kinetic.sum() * sign)
