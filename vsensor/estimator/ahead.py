"""What follows the newest state of the model string: the waves on their way, and the bit's answer to them."""

import math

from vsensor.estimator.learn import load_in_force
from vsensor.estimator.state import BIT, Model, State
from vsensor.estimator.sweep import sweep
from vsensor.jit import compiled

STICK_S = 0.1
"""A bit foretold to rest for so long sticks: shorter stops are the turning points of an oscillation."""


@compiled
def predict(model: Model, state: State, steps: int) -> None:
    """March on to now, or to the end of the forecast; `ahead` then holds the bit at each of these steps."""
    known = state.ticks[0] * model.steps + model.steps - 1
    for junction in range(state.marching.shape[0]):
        state.marching[junction] = state.junctions[0, junction]
    sweep(
        model.line,
        load_in_force(state.learned, model.bit_rate),
        state.waves[0],
        known,
        steps,
        state.rock[0] * model.fade,
        model.fade,
        state.marching,
        state.balances[0, BIT],
        state.ahead,
    )


@compiled
def stick_ahead(model: Model, state: State) -> float:
    """Time from now until the bit is foretold to stick, s; 0 while it does; NaN where it does not."""
    step_s = 1.0 / (model.rate * model.steps)
    lasting = math.ceil(STICK_S / step_s)
    rests = 0
    for step in range(max(0, model.now - lasting), model.forecast):
        rests = rests + 1 if state.ahead[0, step] == 0 else 0
        if rests == lasting:
            return max(0.0, (step + 1 - rests - (model.now - 1)) * step_s)
    return math.nan
