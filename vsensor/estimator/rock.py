"""How restless the rock is: it decides which gains are in force."""

import math

from vsensor.estimator.learn import SLIDING, load_in_force
from vsensor.estimator.load import law
from vsensor.estimator.responses import TOLD_BIT_TORQUE
from vsensor.estimator.state import Model, State
from vsensor.jit import compiled

MEMORY_S = 5.0
"""Time over which the rock's restlessness is forgotten."""
STEPS_APART = 0.3
"""Another level must be nearer by so much, in the logarithm of the variance, half of which is 0.7."""
WILD = 4.0
"""A residual beyond so many deviations counts as one of so many."""


@compiled
def weigh_rock(model: Model, state: State, speed: float, torque: float) -> None:
    """Take a confirmed pair of a sliding bit: what the law leaves over, and what is not told of it.

    (The step of expectation and maximisation for a variance: Shumway and Stoffer 1982.)
    """
    if abs(speed) < SLIDING:
        return
    left = torque - law(load_in_force(state.learned, model.bit_rate), speed)
    gains = model.gains
    untold = gains.variance[state.level[0], TOLD_BIT_TORQUE] * state.noisier[0]
    square = min(left * left, WILD * WILD * state.rock_square[0]) + untold
    state.rock_square[0] += (square - state.rock_square[0]) / (MEMORY_S * model.rate)
    nearest = 0
    for level in range(gains.levels.shape[0]):
        if _apart(state, gains.levels[level]) < _apart(state, gains.levels[nearest]):
            nearest = level
    if _apart(state, gains.levels[nearest]) < _apart(state, gains.levels[state.level[0]]) - STEPS_APART:
        state.level[0] = nearest


@compiled
def _apart(state: State, level: float) -> float:
    return abs(math.log(level * level * state.noisier[0] / state.rock_square[0]))
