"""What follows the newest state of the model string: the waves on their way, and the bit's answer to them.

On a long string a march has many steps, and the bit's speed changes over tenths of a second: to foretell it
REFRESH_HZ times a second is enough. Where ticks come faster, a march is spread over several of them.
"""

import math

from vsensor.estimator.learn import load_in_force
from vsensor.estimator.ring import mask_of
from vsensor.estimator.score import HORIZONS
from vsensor.estimator.state import BIT, END, NEXT, NONE, TOLD, Model, State
from vsensor.estimator.sweep import BALANCE, EXTERNAL, Span, sweep
from vsensor.jit import compiled, inlined

REFRESH_HZ = 100.0
"""So many marches are begun in a second, at the most:"""
WORTH = 0.02
"""or more, for it is read no further beyond what was known when it set out than so much of a round trip."""


def shares_of(rate: float, round_trip: float) -> int:
    """Over how many ticks a march is spread, of a string with a round trip of so many."""
    return max(1, min(int(rate / REFRESH_HZ), 1 + int(WORTH * round_trip / 2)))


@compiled
def read_beyond(shares: int, steps: int) -> int:
    """Steps that a march goes further than is asked: it is read until the next has caught up."""
    return 2 * (shares - 1) * steps


@compiled
def reach(model: Model, kinds: int) -> int:
    """Steps that a march must tell of for the first so many horizons.

    Beyond the last of them it goes on until a bit that stops before is seen to stick. What the top will do by
    then has not been heard: it is taken to stay as it is.
    """
    return int(model.horizons[kinds - 1]) + (model.lasting if kinds == HORIZONS else 0)


@inlined
def predict(model: Model, state: State, steps: int) -> None:
    """March on, until `ahead` tells of the bit at each of so many steps after the newest.

    The march under way goes on by this tick's share; where that is not enough, as at the start or where
    more is asked than before, a whole one is made.
    """
    next_step = (state.ticks[0] + 1) * model.steps
    share = state.ticks[0] % model.shares
    end = next_step + steps + read_beyond(model.shares, model.steps)
    if state.course[NEXT] != NONE:
        if share == 0:
            _set_out(model, state, next_step, end)
        begun = next_step - share * model.steps
        whole = state.course[END] - begun
        _go_on(model, state, next_step, begun + whole * (share + 1) // model.shares)
    if state.course[TOLD] < next_step + steps:
        _set_out(model, state, next_step, end)
        _go_on(model, state, next_step, end)


@inlined
def _set_out(model: Model, state: State, first: int, end: int) -> None:
    """Begin a march of the steps from `first` to before `end`."""
    state.course[NEXT], state.course[END] = first, end
    for junction in range(state.marching.shape[0]):
        state.marching[junction] = state.junctions[0, junction]
    state.carried[EXTERNAL] = state.rock[0] * model.fade
    state.carried[BALANCE] = state.balances[0, BIT]


@inlined
def _go_on(model: Model, state: State, unknown: int, until: int) -> None:
    """March to before step `until`; the top is known to before step `unknown`."""
    course = state.course
    if until > course[NEXT]:
        load = load_in_force(state.learned, model.bit_rate)
        span = Span(unknown - 1, course[NEXT], until, course[END])
        sweep(model.line, load, state.waves[0], span, model.fade, state.marching, state.carried, state.ahead)
        course[NEXT] = until
    # What the march before told of what lies beyond is overtaken in the end.
    course[TOLD] = course[END] if course[NEXT] >= course[END] else max(course[NEXT], course[TOLD])


@inlined
def stick_ahead(model: Model, state: State) -> float:
    """Time from now until the bit is foretold to stick, s; 0 while it does; NaN where it does not."""
    first = state.ticks[0] * model.steps + model.steps
    mask = mask_of(state.ahead.shape[1])
    rests = 0
    for step in range(max(0, model.now - model.lasting), reach(model, HORIZONS)):
        rests = rests + 1 if state.ahead[0, (first + step) & mask] == 0 else 0
        if rests == model.lasting:
            return time_to(model, step + 1 - rests)
    return math.nan


@inlined
def time_to(model: Model, step: int) -> float:
    """Time from now until so many steps of a march were made, s; 0 where that is past."""
    return max(0.0, (step - (model.now - 1)) * (1.0 / (model.rate * model.steps)))
