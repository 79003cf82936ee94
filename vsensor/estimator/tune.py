"""The configuration corrected by the record itself: delay, top-drive inertia, wall friction, torque's zero.

Beside the model string run shadows of it: with longer delays and with shorter ones, with more inertia and
with less. What their answers differ by tells what an uncertain parameter costs the answer. Whose innovations
are smallest is nearest to the truth, and a parabola through the sums of squares with longer delays, with
those in force and with shorter ones tells where the delay lies and how surely (maximum likelihood, Ljung
1999, chapter 7).

The other three cannot be told while there is a rock, which innovations lay everything to. Off bottom there
is none, and a tare tells them (tare.py).
"""

from typing import NamedTuple

import numpy as np

from vsensor.config import Tuning as Settings
from vsensor.estimator.sections import Floats, Integers, Line, stretched
from vsensor.jit import compiled

DELAY, INERTIA, FRICTION, OFFSET = range(4)
PARAMETERS = 4
TARED = slice(INERTIA, PARAMETERS)
"""Those that a tare tells."""
SHADOWED = 2
"""Delay and inertia have shadows, a pair each: more of it, and less."""
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
"""The model is not the string: what innovations tell of the delay counts for a twentieth,"""
BIAS = 0.001
"""and is no better than this, one deviation, however long the record: where impedance, friction or law were
wrong by what is usual, the likeliest delay of simulated records was off by up to a thousandth."""
SETTLED_S = 60.0
"""Not before the load law was learned for as long as it remembers: its errors would be laid to the string."""


class Tuning(NamedTuple):
    """What is known of the parameters: shares of what is configured, and the torque's offset in N·m."""

    prior: Floats
    """Variance of each before the record said anything, shape (4,)."""
    value: Floats
    """The corrections in force, shape (4,)."""
    variance: Floats
    """Mean square of what they may still be wrong by, shape (4,)."""
    shared: Floats
    """The same of friction times offset, N·m, shape (1,)."""
    misfit: Floats
    """Sums of squared innovations with the delays in force, with longer and with shorter ones, shape (3,)."""
    information: Floats
    """What tares told of inertia, friction and offset: weighted sums of the products of what each does to the
    torque off bottom, shape (3, 3),"""
    pulls: Floats
    """and of that times the torque left over, shape (3,)."""
    steady: Integers
    """Ticks for which the string has turned as one off bottom, shape (1,)."""


def fresh_tuning(settings: Settings, passed: float) -> Tuning:
    """Nothing told yet: what the configuration says of its own error. Gear and drive make 1 N·m `passed`."""
    shares = settings.delay, settings.inertia, settings.friction
    prior = np.array([*shares, settings.torque_offset * passed]) ** 2
    return Tuning(
        prior=prior,
        value=np.zeros(PARAMETERS),
        variance=prior.copy(),
        shared=np.zeros(1),
        misfit=np.zeros(3),
        information=np.zeros((3, 3)),
        pulls=np.zeros(3),
        steady=np.zeros(1, np.int64),
    )


def correct_delay(tuning: Tuning, off: float, enabled: bool) -> bool:
    """Take up a correction of the delays that is due; whether there was one. `off` is the shadows' share."""
    information, pull = _parabola(tuning, off)
    prior = float(tuning.prior[DELAY])
    variance = 1 / (information + 1 / prior)
    due = bounded(tuning, DELAY, variance * pull)
    here, more, less = tuning.misfit.tolist()
    # A valley's side tells the way, not how far: only one whose floor was seen tells how surely.
    known = variance if here < more and here < less else prior
    if not enabled or due * due <= SURELY**2 * variance:
        # What is in force is not what is likeliest: its mean square error holds the difference.
        tuning.variance[DELAY] = known + due * due
        return False
    tuning.variance[DELAY] = known
    # No further than the shadows were, for there they must look anew.
    tuning.value[DELAY] += min(max(due, -off), off)
    tuning.misfit[:] = 0.0
    return True


def bounded(tuning: Tuning, p: int, due: float) -> float:
    """As much of a correction as leaves a parameter within its bounds."""
    value, bound = float(tuning.value[p]), BOUND * float(tuning.prior[p]) ** 0.5
    return float(min(max(due, -bound - value), bound - value))


def _parabola(tuning: Tuning, off: float) -> tuple[float, float]:
    """Information on a correction, and where it pulls: of the parabola through three misfits."""
    here, more, less = tuning.misfit.tolist()
    information = WORTH * (more - 2 * here + less) / (2 * off * off)
    pull = WORTH * (less - more) / (4 * off)
    # Far from the truth the valley has no floor yet: its side tells the way, and that it is far.
    information = max(information, abs(pull) / (2 * off))
    blurred = 1 + information * BIAS**2
    return information / blurred, pull / blurred


def tuned(line: Line, value: Floats) -> Line:
    """The line with delay and friction corrected."""
    rough = 1 + value[FRICTION]
    return stretched(line, float(value[DELAY]))._replace(
        viscous=line.viscous * rough, kinetic=line.kinetic * rough, static=line.static * rough
    )


@compiled
def wall_torque(line: Line, speed: float) -> float:
    """Friction along the whole string, N·m, while all of it turns at `speed`."""
    sign = 1.0 if speed > 0 else -1.0 if speed < 0 else 0.0
    return float(line.viscous.sum() * speed + line.kinetic.sum() * sign)
