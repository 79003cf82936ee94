"""The configuration corrected by the record itself: delay, top-drive inertia, wall friction, torque's zero.

Beside the model string run shadows of it: with longer delays and with shorter ones, with more inertia and
with less. Whose innovations are smallest is nearest to the truth, and a parabola through the three sums of
squares of a parameter tells where it lies and how surely (maximum likelihood, Ljung 1999, chapter 7). What
the shadows' answers differ by tells what an uncertain parameter costs the answer.

Friction, and an offset of the torque reading, cannot be told from the bit's torque while there is any. Off
bottom there is none, and what is left over of the bit's torque is theirs: a tare. It is parted by what either
may be wrong by, and by the wall's torque, which goes with the speed; the offset does not (linear regression
with normal priors, Box and Tiao 1973).
"""

from typing import NamedTuple

import numpy as np

from vsensor.config import Tuning as Settings
from vsensor.estimator.sections import Floats, Integers, Line, stretched
from vsensor.jit import compiled

DELAY, INERTIA, FRICTION, OFFSET = range(4)
PARAMETERS = 4
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
    """What is known of the parameters: shares of what is configured, and the torque's offset in N·m."""

    prior: Floats
    """Variance of each before the record said anything, shape (4,)."""
    value: Floats
    """The corrections in force, shape (4,)."""
    variance: Floats
    """Of what is still uncertain, shape (4,)."""
    shared: Floats
    """Covariance of what is uncertain of friction and offset, N·m, shape (1,)."""
    misfit: Floats
    """Sums of squared innovations in force, with more and with less of each parameter, shape (2, 3)."""
    tare: Floats
    """What off bottom was told of friction and offset: weighted sums of wall², wall and 1, and of the torque
    left over times wall and times 1, shape (5,)."""
    steady: Integers
    """Ticks for which the string has turned steadily off bottom, shape (1,)."""


def fresh_tuning(settings: Settings, passed: float) -> Tuning:
    """Nothing told yet: what the configuration says of its own error. Gear and drive make 1 N·m `passed`."""
    shares = settings.delay, settings.inertia, settings.friction
    prior = np.array([*shares, settings.torque_offset * passed]) ** 2
    return Tuning(
        prior=prior,
        value=np.zeros(PARAMETERS),
        variance=prior.copy(),
        shared=np.zeros(1),
        misfit=np.zeros((SHADOWED, 3)),
        tare=np.zeros(5),
        steady=np.zeros(1, np.int64),
    )


def correct(tuning: Tuning, off: Floats, enabled: bool) -> bool:
    """Take up the corrections that are due; whether there were any. `off` (2,) is what shadows are off by."""
    changed = [_correct_by_shadows(tuning, p, float(off[p]), enabled) for p in range(SHADOWED)]
    return _correct_by_tare(tuning, enabled) or any(changed)


def _correct_by_shadows(tuning: Tuning, p: int, off: float, enabled: bool) -> bool:
    information, pull = _parabola(tuning, p, off)
    tuning.variance[p] = variance = 1 / (information + 1 / float(tuning.prior[p]))
    due = _bounded(tuning, p, variance * pull)
    if not enabled or due * due <= SURELY**2 * variance:
        return False
    # No further than the shadows were, for there they must look anew.
    tuning.value[p] += min(max(due, -off), off)
    tuning.misfit[:] = 0.0
    return True


def _correct_by_tare(tuning: Tuning, enabled: bool) -> bool:
    """Friction and offset together: what is left of the torque may be surely theirs, and neither's surely."""
    walls, wall, one, *pulls = tuning.tare.tolist()
    friction, offset = tuning.prior[FRICTION:].tolist()
    # P (1 + A P)⁻¹ of priors P and information A: what has no prior deviation has none afterwards.
    determinant = (1 + walls * friction) * (1 + one * offset) - wall * wall * friction * offset
    shared = -wall * friction * offset / determinant
    tuning.variance[FRICTION:] = variances = np.array(
        [friction * (1 + one * offset) / determinant, offset * (1 + walls * friction) / determinant]
    )
    tuning.shared[0] = shared
    dues = variances * pulls + shared * np.array(pulls[::-1])
    if not enabled or float(dues @ pulls) <= SURELY**2:
        return False
    bounded = [_bounded(tuning, p, float(due)) for p, due in zip((FRICTION, OFFSET), dues, strict=True)]
    tuning.value[FRICTION:] += bounded
    # Pairs of before the correction are still on their way.
    tuning.tare[3:] = 0.0
    tuning.steady[0] = 0
    return any(bounded)


def _bounded(tuning: Tuning, p: int, due: float) -> float:
    value, bound = float(tuning.value[p]), BOUND * float(tuning.prior[p]) ** 0.5
    return float(min(max(due, -bound - value), bound - value))


def _parabola(tuning: Tuning, p: int, off: float) -> tuple[float, float]:
    """Information on a correction, and where it pulls: of the parabola through three misfits."""
    here, more, less = tuning.misfit[p].tolist()
    information = WORTH * (more - 2 * here + less) / (2 * off * off)
    pull = WORTH * (less - more) / (4 * off)
    # Far from the truth the valley has no floor yet: its side tells the way, and that it is far.
    return max(information, abs(pull) / (2 * off)), pull


def tuned(line: Line, value: Floats) -> Line:
    """The line with delay and friction corrected."""
    rough = 1 + value[FRICTION]
    return stretched(line, float(value[DELAY]))._replace(
        viscous=line.viscous * rough, kinetic=line.kinetic * rough, static=line.static * rough
    )


@compiled
def weigh_tare(tuning: Tuning, wall: float, torque: float, doubt: float, rate: float) -> None:
    """Learn from a bit torque that is truly zero, told with the variance `doubt`; the wall takes `wall`."""
    weight = 1.0 / (APART_S * rate * doubt)
    keep = 1.0 - 1.0 / (TARE_S * rate)
    tare = tuning.tare
    tare[0] = keep * tare[0] + weight * wall * wall
    tare[1] = keep * tare[1] + weight * wall
    tare[2] = keep * tare[2] + weight
    tare[3] = keep * tare[3] + weight * wall * torque
    tare[4] = keep * tare[4] + weight * torque


@compiled
def wall_torque(line: Line, speed: float) -> float:
    """Friction along the whole string, N·m, while all of it turns at `speed`."""
    sign = 1.0 if speed > 0 else -1.0 if speed < 0 else 0.0
    return float(line.viscous.sum() * speed + line.kinetic.sum() * sign)
