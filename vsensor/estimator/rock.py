"""How restless the rock is, as innovations tell: it decides which gains are in force.

All that the bit does and the law does not foresee counts as rock. Where the rock's variance is m times that
of the level in force, the innovations have the spectrum

    s (1 + (m − 1) D),    D = q |Y|² / S    the rock's share of what is seen (gains.py)

and the score of Whittle's likelihood (1953) at m = 1, I their periodogram, tells of m:

    m − 1 = (mean of D I / s − mean of D) / mean of D²

In time D is how far innovations hang together that should not, d(n) by ticks apart: of each innovation v
there is v (d(0) v + 2 Σ d(n) v(−n)) in place of D I. Where they are larger than they should be all told, as
where something else is wrong, s is what they are: then only how they hang together tells.
"""

import math

from vsensor.estimator.learn import SLIDING, load_in_force
from vsensor.estimator.load import law
from vsensor.estimator.ring import weighted
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import Model, State
from vsensor.jit import compiled, inlined

MEMORY_S = 5.0
"""Time over which the rock's restlessness is forgotten,"""
SOON_S = 2.0
"""or so soon where it asks more than holds the bit, as off bottom: its torque does not turn about,"""
SURE = 4.0
"""or longer, where innovations tell so little that by chance its variance would be off by half of itself."""
LEAST, MOST = 0.05, 16.0
"""The rock's variance is never taken to be a smaller or a larger multiple of the level's in force: it is told
of near that."""
STEPS_APART = 0.3
"""Another level must be nearer by so much, in the logarithm of the variance, half of which is 0.7."""


@compiled
def weigh_rock(model: Model, state: State) -> None:
    """Take this tick's innovation, if there is one, of a bit that slides: at rest it is asked nothing."""
    innovation, speed = state.innovation[0], state.junctions[0, -1]
    if math.isnan(innovation) or abs(speed) < SLIDING:
        return
    level, gains = state.level[0], model.gains
    traces, telling = gains.traces[level], gains.telling[level]
    expected = gains.innovation[level] * state.noisier[0] * max(1.0, state.surprise[0])
    assumed = gains.levels[level] ** 2 * state.noisier[0]
    hangs = innovation * hang_together(traces, state.innovations, state.ticks[0]) / expected - traces[0]
    square, held = state.rock_square[0], law(load_in_force(state.learned, model.bit_rate), speed)
    memory_s = SOON_S if square > held * held else MEMORY_S
    # Of a rock that no innovation tells of at all nothing is taken, and divided by nothing.
    square += (assumed * (telling + hangs) - square * telling) / max(memory_s * model.rate * telling, SURE)
    state.rock_square[0] = min(max(square, LEAST * assumed), MOST * assumed)
    choose_level(model, state)


@compiled
def hang_together(traces: Floats, innovations: Floats, tick: int) -> float:
    """By how much the newest of a ring of innovations hangs together with itself and those before."""
    size = innovations.shape[0]
    at = tick % size
    before = min(traces.shape[0] - 1, at)
    rest = traces.shape[0] - 1 - before
    near = weighted(innovations[at - before : at], 1, traces[1 : 1 + before])
    far = weighted(innovations[size - rest :], 1, traces[1 + before :])
    return float(traces[0] * innovations[at] + 2.0 * (near + far))


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
