"""Whether a state that was handed to us can be gone on with.

Kernels look up what its numbers say without a check of their own: a level that is none, or a delay that the
rings were not laid out for, would read and write beyond the arrays. So all that is looked up by, looped over
or divided by is held here against what the estimator itself could have come to; of all else, that no product
of it overflows.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vsensor.config import Tuning as Settings
from vsensor.estimator.ahead import read_beyond
from vsensor.estimator.learn import KINETIC, STATIC, Learned
from vsensor.estimator.ring import room_of
from vsensor.estimator.score import CHANGE, EXPECTED, VALUE, Scores
from vsensor.estimator.sections import Floats
from vsensor.estimator.setdown import AWAITED
from vsensor.estimator.state import END, NEVER, NEXT, NONE, Model, State
from vsensor.estimator.tune import BOUND, TARED, Tuning, fresh_tuning

LARGEST = 1e12
"""No speed in rad/s and no torque in N·m of a string is so large;"""
SUMS = LARGEST**3
"""nor a weighted sum of their squares;"""
RATIOS = LARGEST**5
"""nor what scores keep, who divide such squares by each other."""
LEAST = 1e-40
"""A variance that is divided by is not so small."""
LONGEST = 1 << 45
"""Ticks, and internal steps with them, are counted in 64 bits: so many are two centuries at 5 kHz."""
ROUNDING = 1e-9

MOVING = (
    "inputs",
    "motor",
    "waves",
    "returned",
    "innovations",
    "junctions",
    "balances",
    "rock",
    "told",
    "marching",
    "carried",
    "ahead",
)
"""Speeds and torques of either sign."""


def refuse_unsound(model: Model, settings: Settings, state: State) -> None:
    """Raise ValueError, naming the array and what would be right, where a state cannot be gone on with.

    `model` as configured, before any correction. Shapes and types are right already (`arrays.fill`).
    """
    for name in MOVING:
        _within(name, getattr(state, name), -LARGEST, LARGEST)
    known = state.innovation[~np.isnan(state.innovation)]
    _within("innovation", known, -LARGEST, LARGEST)
    _within("held", state.held, 0, LARGEST)
    _within("slips", state.slips, 0, LARGEST)
    _within("missing", state.missing, 0, 1)
    _within("surprise", state.surprise, 0, LARGEST**2)
    _within("unforeseen", state.unforeseen, 0, LARGEST**2)
    _within("rock_square", state.rock_square, LEAST, LARGEST**2)
    _within("steps", state.steps, 0, LARGEST)
    _within("resolution", state.resolution, 0, LARGEST)
    _within("bends", state.bends, 0, LARGEST)
    _within("lasts", state.lasts, 1, LARGEST)
    _within("white", state.white, 0, LARGEST**2)
    _within("noisier", state.noisier, 1, LARGEST**2)
    for name in ("level", "levels"):
        _within(name, getattr(state, name), 0, len(model.gains.levels) - 1)
    _times(model, state)
    _learned(state.learned)
    _scores(state.scores)
    _tuning(state.tuning, fresh_tuning(settings, model.passed).prior)


def _times(model: Model, state: State) -> None:
    """Ticks, and what is counted in them."""
    _within("ticks", state.ticks, 0, LONGEST)
    done, laid = state.ticks.tolist()
    _within("ticks", laid, 0, max(done - 1, 0), "of waves laid at one of the ticks done")
    _within("off_bottom", state.off_bottom, -done, done, "within the ticks done")
    seen = state.last_seen[state.last_seen != NEVER]
    _within("last_seen", seen, 0, done - 1, "of ticks done")
    course = state.course
    if (course == NONE).all():
        return
    # Of the last tick; the march is told of in a ring, and was begun a few ticks ago.
    newest = done * model.steps
    reach = model.steps + read_beyond(model.shares, model.steps)
    room = room_of(state.ahead.shape[1])
    _within("course", course, newest - reach, newest + room, "of the present march, or none")
    _within("course", course[NEXT], newest - reach, course[END], "before the march's end")


def _learned(learned: Learned) -> None:
    """The load law and what it was learned from."""
    _within("learned.speeds", learned.speeds, LEAST, LARGEST)
    _within("learned.fits", learned.fits, 0, LARGEST)
    _within("learned.fits", learned.fits[:, KINETIC], 0, learned.fits[:, STATIC], "no more than static")
    _within("learned.stop", learned.stop, 0, LONGEST)
    chosen = int(learned.stop[1])
    _within("learned.stop", chosen, 0, len(learned.speeds) - 1, "of a candidate")
    in_force = np.append(learned.fits[chosen], learned.speeds[chosen])
    _within("learned.law", learned.law, in_force, in_force, "as the candidate in force was fitted")
    _gram("learned.normal", learned.normal)
    _within("learned.right", learned.right, -SUMS, SUMS)
    _within("learned.square", learned.square, 0, SUMS)
    _within("learned.scale", learned.scale, 0, LARGEST)
    _within("learned.idle", learned.idle[0], 0, AWAITED)
    _within("learned.idle", learned.idle[1], 0, LONGEST)


def _scores(scores: Scores) -> None:
    """What was foretold, NaN where nothing was, and how far it missed."""
    value = scores.foretold[:, :, VALUE]
    known = ~np.isnan(value)
    _within("scores.foretold", value[known], -LARGEST, LARGEST)
    _within("scores.foretold", scores.foretold[:, :, CHANGE][known], -LARGEST, LARGEST)
    _within("scores.foretold", scores.foretold[:, :, EXPECTED][known], LEAST, LARGEST**2, "as a variance")
    _within("scores.laws", scores.laws[~np.isnan(scores.laws)], 0, SUMS)
    _within("scores.sums", scores.sums, 0, RATIOS)
    _within("scores.sums", scores.sums[..., 0], LEAST, RATIOS, "as a divisor")
    _within("scores.law", scores.law, 0, SUMS)
    _within("scores.misses", scores.misses, 0, SUMS)
    _within("scores.scored", scores.scored, 0, LONGEST)


def _tuning(tuning: Tuning, prior: Floats) -> None:
    """The corrections: rings are laid out for those alone that the configuration allows."""
    _within("tuning.prior", tuning.prior, prior, prior, "as configured")
    bound = BOUND * np.sqrt(prior) * (1 + ROUNDING)
    _within("tuning.value", tuning.value, -bound, bound, "of what is configured")
    _within("tuning.variance", tuning.variance, 0, LARGEST**2)
    _within("tuning.shared", tuning.shared, -(LARGEST**2), LARGEST**2)
    _within("tuning.misfit", tuning.misfit, 0, SUMS)
    _within("tuning.crossed", tuning.crossed, -SUMS, SUMS)
    deviations = np.sqrt(prior[TARED])
    _within("tuning.information", tuning.information, -SUMS, SUMS)
    _gram("tuning.information", tuning.information * np.outer(deviations, deviations))
    _within("tuning.pulls", tuning.pulls, -SUMS, SUMS)
    _within("tuning.doubt", tuning.doubt, LEAST, SUMS)
    _within("tuning.asked", tuning.asked, -SUMS, SUMS)
    _within("tuning.steady", tuning.steady, 0, LONGEST)
    _within("tuning.too_low", tuning.too_low, 0, 1)


def _within(name: str, held: ArrayLike, low: ArrayLike, high: ArrayLike, what: str = "") -> None:
    """Hold numbers to bounds, one for all or one for each. What is not a number is out of bounds."""
    array, least, most = np.broadcast_arrays(np.asarray(held), low, high)
    wrong = ~((least <= array) & (array <= most))
    if wrong.any():
        asked = f"{least[wrong][0]:.12g} to {most[wrong][0]:.12g}"
        raise ValueError(
            f"saved state: {name} holds {array[wrong][0]:.12g} where {asked} is right{what and ', '}{what}"
        )


def _gram(name: str, sums: NDArray[np.float64]) -> None:
    """Hold matrices (…, 3, 3) to be sums of weighted products: only such least squares have a solution."""
    _within(name, sums, -SUMS, SUMS)
    other = np.swapaxes(sums, -1, -2)
    scale = np.trace(sums, axis1=-2, axis2=-1)[..., None, None]
    _within(name, sums - other, -ROUNDING * scale, ROUNDING * scale, "of a symmetric matrix")
    least = np.linalg.eigvalsh((sums + other) / 2)[..., :1, None]
    _within(name, least, -ROUNDING * scale, np.inf, "of the eigenvalues of sums of squares")
