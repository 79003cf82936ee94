"""What follows the newest state of the model string: the waves that are on their way, and the bit's answer."""

from vsensor.estimator.learn import load_in_force
from vsensor.estimator.line import march
from vsensor.estimator.state import BIT, Model, State
from vsensor.jit import compiled


@compiled
def predict(model: Model, state: State) -> None:
    """March on to now and to the end of the forecast; `ahead` then holds the bit at each step."""
    known = state.ticks[0] * model.steps + model.steps - 1
    state.marching[:] = state.junctions
    march(
        model.line,
        load_in_force(state.learned, model.bit_rate),
        state.waves,
        known,
        model.forecast,
        known,
        model.forecast,
        state.rock[0] * model.fade,
        model.fade,
        state.marching,
        state.balances[BIT],
        state.ahead,
    )
