"""How restless the rock is: it decides which gains are in force."""

import math

from vsensor.estimator.learn import SLIDING, load_in_force, weight_of
from vsensor.estimator.load import law
from vsensor.estimator.responses import TOLD_BIT_TORQUE
from vsensor.estimator.state import Model, State
from vsensor.jit import compiled, inlined

MEMORY_S = 5.0
"""Time over which the rock's restlessness is forgotten."""
SURE_S = 3.0
"""What holds the bit is known once the law rests on so long a time of sliding;"""
SOON_S = 2.0
"""then a rock more restless than that is forgotten within so long: its torque does not turn about."""
LEAST = 0.05
"""The rock's variance is never taken to be a smaller share of the level's in force."""
STEPS_APART = 0.3
"""Another level must be nearer by so much, in the logarithm of the variance, half of which is 0.7."""
WILD = 4.0
"""A residual beyond so many deviations counts as one of so many."""


@compiled
def weigh_rock(model: Model, state: State, speed: float, torque: float) -> None:
    """Take a confirmed pair of a sliding bit: what the law leaves over, and what is not told of it.

    (The step of expectation and maximisation for a variance: Shumway and Stoffer 1982.) It leaves the rock
    near the level in force where little of it is told, the more so the calmer it is. So rock that is held to
    be more restless than could be is measured at once by what alone is told of it: of the square of what the
    law leaves over a share ε² is the rock's and ε (1 − ε) the level's, ε the share that gains tell of theirs.
    """
    if abs(speed) < SLIDING:
        return
    held = law(load_in_force(state.learned, model.bit_rate), speed)
    left = torque - held
    square, gains = state.rock_square[0], model.gains
    assumed = gains.levels[state.level[0]] ** 2 * state.noisier[0]
    untold = gains.variance[state.level[0], TOLD_BIT_TORQUE] * state.noisier[0]
    seen = min(left * left, WILD * WILD * square)
    if square > held * held and weight_of(state.learned) > SURE_S * model.rate:
        told = 1.0 - untold / assumed
        square += (assumed + (seen - told * assumed) / (told * told) - square) / (SOON_S * model.rate)
    else:
        square += (seen + untold - square) / (MEMORY_S * model.rate)
    state.rock_square[0] = max(square, LEAST * assumed)
    choose_level(model, state)


@inlined
def choose_level(model: Model, state: State) -> None:
    """Put the gains in force that are for a rock so restless, beside channels so noisy."""
    levels = model.gains.levels
    nearest = 0
    for level in range(levels.shape[0]):
        if _apart(state, levels[level]) < _apart(state, levels[nearest]):
            nearest = level
    if _apart(state, levels[nearest]) < _apart(state, levels[state.level[0]]) - STEPS_APART:
        state.level[0] = nearest


@inlined
def _apart(state: State, level: float) -> float:
    return abs(math.log(level * level * state.noisier[0] / state.rock_square[0]))
