"""One tick of the estimator, compiled: take the input, observe, score, learn, march, answer."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from vsensor.estimator.abreast import Room, ask, march_abreast, set_out
from vsensor.estimator.ahead import predict, reach, stick_ahead
from vsensor.estimator.doubt import doubt, doubt_by_noise
from vsensor.estimator.inputs import enter, follow_bit, lasting
from vsensor.estimator.learn import lose_sight
from vsensor.estimator.observe import note_rest, observe, settle
from vsensor.estimator.ring import mask_of
from vsensor.estimator.rock import weigh_rock
from vsensor.estimator.score import FORECAST as LAST
from vsensor.estimator.score import HORIZONS, VALUE, expect, foretell, missed, score
from vsensor.estimator.score import NOW as FIRST
from vsensor.estimator.sections import Floats
from vsensor.estimator.setdown import meets_rock
from vsensor.estimator.slips import held_by_slips
from vsensor.estimator.state import NONE, Model, State
from vsensor.estimator.study import (
    await_rock,
    bound_wall,
    confirmed_step,
    foretold_for,
    study_law,
    study_string,
    study_wall,
)
from vsensor.estimator.tune import OFFSET, STRINGS
from vsensor.jit import compiled, inlined
from vsensor.quality import Reason

CONFIRMED, NOW, FORECAST = 0, 4, 8
"""Where each answer starts in a row of output: speed, its deviation, torque, its deviation."""
SPEED, SPEED_STD, TORQUE, TORQUE_STD = range(4)
TOP = 12
"""The string's top at the time that is confirmed, in the same order."""
STICK = 16
"""Time until the bit is foretold to stick, s; NaN where it is not."""
COLUMNS = 17

CHANGE_S = 0.05
"""Over so long a prediction's change is taken."""
OFF_BOTTOM = 1 << 16
"""Flag of an input: the bit is off bottom. Not a reason to doubt anything."""
NO_FORECAST = 1 << 17
"""Flag of an input: there is no time to foretell anything beyond now."""
LOST = 1e4
"""Innovations a hundred times larger than expected: the model string has nothing to do with the real one."""

_WARMING_UP = int(Reason.WARMING_UP)
_STALE = int(Reason.STALE_TORQUE | Reason.STALE_SPEED)
_NOT_MEASURED = _WARMING_UP | _STALE
_IN_SLIPS = int(Reason.IN_SLIPS)
_TORQUE_TOO_LOW = int(Reason.TORQUE_TOO_LOW)


@compiled
def turns(
    model: Model,
    state: State,
    torque: Floats,
    speed: Floats,
    reasons: NDArray[np.uint32],
    out: Floats,
    out_reasons: NDArray[np.uint32],
) -> Iterator[int]:
    """Run n ticks at each turn: inputs (n,), `out` (n, COLUMNS) and `out_reasons` (n,) are filled anew.

    `reasons` (n,) holds flags of `quality.Reason`, OFF_BOTTOM and NO_FORECAST. An input that is not finite,
    or beyond belief, counts as missing: the last one is held, and flagged. No allocation. Yields n.

    A generator, as that is handed model and state once: to take 75 arrays from Python at each tick takes half
    as long as the tick. It holds on to none of them: who runs it must.
    """
    mask, count = mask_of(state.ahead.shape[1]), torque.shape[0]
    while True:
        for k in range(count):
            out_reasons[k] = _take(model, state, torque[k], speed[k], reasons[k], out[k])
            kinds, tick = _kinds(reasons[k]), state.ticks[0]
            predict(model, state, reach(model, kinds))
            _foretell(model, state, tick, kinds, state.ahead, (tick + 1) * model.steps - 1, mask)
            stick = stick_ahead(model, state) if kinds == HORIZONS else math.nan
            _answer(state, tick, out_reasons[k], stick, out[k])
            state.ticks[0] += 1
        yield count


@compiled
def advance_abreast(
    model: Model,
    state: State,
    room: Room,
    most: int,
    torque: Floats,
    speed: Floats,
    reasons: NDArray[np.uint32],
    out: Floats,
    out_reasons: NDArray[np.uint32],
) -> None:
    """The same to the same bits, `most` ticks marching side by side (abreast.py).

    What `turns` leaves of a march in the state is not there: the last tick before it is saved is to be its.
    """
    for begin in range(0, torque.shape[0], most):
        count = min(most, torque.shape[0] - begin)
        kinds = FIRST + 1
        for k in range(begin, begin + count):
            out_reasons[k] = _take(model, state, torque[k], speed[k], reasons[k], out[k])
            set_out(model, state, room, k - begin)
            kinds = max(kinds, _kinds(reasons[k]))
            state.ticks[0] += 1
        for kind in range(kinds):
            ask(room, model.horizons[kind])
            ask(room, _before(model, kind))
        march_abreast(model, room, reach(model, kinds))
        for k in range(begin, begin + count):
            kinds, lane = _kinds(reasons[k]), k - begin
            tick = state.ticks[0] - count + lane
            _foretell(model, state, tick, kinds, room.told[:, :, lane], -1, -1)
            stick = room.sticks[lane] if kinds == HORIZONS else math.nan
            _answer(state, tick, out_reasons[k], stick, out[k])


@inlined
def _kinds(reasons: int) -> int:
    """How many of the horizons are foretold."""
    return FIRST + 1 if reasons & NO_FORECAST else HORIZONS


@inlined
def _take(model: Model, state: State, torque: float, speed: float, reasons: int, out: Floats) -> int:
    """All of a tick but the march: returns the flags of its answers, and lays these out (`_lay_out`)."""
    flags = enter(model, state, torque, speed, int(reasons) & (OFF_BOTTOM - 1))
    follow_bit(model, state, reasons & OFF_BOTTOM != 0)
    if state.ticks[0] == 0 or state.surprise[0] > LOST:
        _lay(model, state)
    doubts = lasting(model, state, flags)
    observe(model, state)
    note_rest(model, state)
    if not doubts & _NOT_MEASURED:
        _score(model, state)
    if not doubts & ~_TORQUE_TOO_LOW and state.off_bottom[0] <= 0:
        bound_wall(model, state)  # which tells, too, that the torque is no longer too low
    if doubts:
        lose_sight(state.learned)
    elif state.off_bottom[0] > 0:
        study_wall(model, state)
    elif meets_rock(state.learned):
        study_law(model, state)
    else:
        await_rock(model, state)
    if not doubts:
        weigh_rock(model, state)
        study_string(model, state)
    _expect(model, state, _kinds(reasons))
    _lay_out(model, state, doubts, out)
    return doubts


@inlined
def _lay(model: Model, state: State) -> None:
    """Lay the waves of all strings as of steady rotation, at the start or where they have gone astray."""
    place = state.ticks[0] % state.inputs.shape[1]
    for which in range(STRINGS):
        settle(model, state, which, state.inputs[0, place], state.inputs[1, place])
    state.surprise[:] = 1.0
    state.course[:] = NONE
    state.ticks[1] = state.ticks[0]


@inlined
def _score(model: Model, state: State) -> None:
    """Hold what was foretold against what is confirmed by now."""
    mask = mask_of(state.told.shape[2])
    width = state.scores.foretold.shape[3]
    for kind in range(HORIZONS):
        tick, step = foretold_for(model, state, kind)
        # Nothing was foretold while warming up or short of time, nor of a string that was made longer since.
        if tick < model.span or math.isnan(state.scores.foretold[kind, 0, VALUE, tick % width]):
            continue
        state.scores.scored[kind] += 1
        for q in range(2):
            score(state.scores, kind, q, tick, state.told[0, q, step & mask], model.rate)


@inlined
def _expect(model: Model, state: State, kinds: int) -> None:
    """Note the gains' variance, for this rock, of what is about to be foretold."""
    level = state.level[0]
    restless = state.rock_square[0] / model.gains.levels[level] ** 2
    for kind in range(HORIZONS):
        for q in range(2):
            state.unforeseen[q] = restless * model.gains.unforeseen[level, kind, q]
        expect(state.scores, kind, state.ticks[0], state.unforeseen, kind < kinds)


@inlined
def _foretell(model: Model, state: State, tick: int, kinds: int, told: Floats, known: int, mask: int) -> None:
    """Note what the march of a tick says of the first horizons: `told` (2, …) of the steps after `known`."""
    for kind in range(kinds):
        at, before = model.horizons[kind], _before(model, kind)
        for q in range(2):
            value, earlier = told[q, known + at & mask], told[q, known + before & mask]
            foretell(state.scores, kind, q, tick, value, (value - earlier) / _change_steps(model))


@inlined
def _change_steps(model: Model) -> int:
    return max(1, int(CHANGE_S * model.rate * model.steps))


@inlined
def _before(model: Model, kind: int) -> int:
    """The step of a march from which the change to a horizon is taken: that of the first, at the earliest."""
    return max(int(model.horizons[kind]) - _change_steps(model), 1)


@inlined
def _lay_out(model: Model, state: State, reasons: int, out: Floats) -> None:
    """Fill a row with what is known of the answers before the march, `_answer` with the rest.

    In place of deviations stand variances.
    """
    out[:] = math.nan
    if reasons & _WARMING_UP:
        return
    confirmed = confirmed_step(model, state)
    for q in range(2):
        out[CONFIRMED + 2 * q] = state.told[0, q, confirmed & mask_of(state.told.shape[2])]
        out[CONFIRMED + 2 * q + 1] = doubt(model, state, q, confirmed)
    by_slips = held_by_slips(state) if reasons & _IN_SLIPS else 0.0
    out[CONFIRMED + TORQUE_STD] += by_slips
    _answer_top(model, state, by_slips, out)


@inlined
def _answer(state: State, tick: int, reasons: int, stick: float, out: Floats) -> None:
    """Make a tick's answers of what was laid out and foretold; what has no known deviation is not told."""
    if reasons & _WARMING_UP:
        return
    out[STICK] = stick
    scores = state.scores
    place = tick % scores.foretold.shape[3]
    for q in range(2):
        unsure = out[CONFIRMED + 2 * q + 1]
        if reasons & _STALE:  # what was not measured the string was told by the law
            unsure += missed(scores, FIRST, q, tick)
        if math.isnan(unsure):
            out[CONFIRMED + 2 * q] = math.nan
        else:
            _tell(out, CONFIRMED + 2 * q, out[CONFIRMED + 2 * q], unsure)
        for kind, at in ((FIRST, NOW), (LAST, FORECAST)):
            miss = missed(scores, kind, q, tick)
            if not math.isnan(miss):
                # What was foretold was held against a confirmed answer that is not exact itself.
                _tell(out, at + 2 * q, scores.foretold[kind, q, VALUE, place], miss + unsure)


@inlined
def _answer_top(model: Model, state: State, by_slips: float, out: Floats) -> None:
    """The string's top when the bit is confirmed, and what noise, offset and slips leave of doubt."""
    step = confirmed_step(model, state) - (model.now - model.behind * model.steps)
    at = step & mask_of(state.told.shape[2])
    for q in range(2):
        unsure = doubt_by_noise(model, state, 2 + q)
        if q == 1:
            unsure += state.tuning.variance[OFFSET] + by_slips
        _tell(out, TOP + 2 * q, state.told[0, 2 + q, at], unsure)


@inlined
def _tell(out: Floats, at: int, value: float, variance: float) -> None:
    out[at] = value
    out[at + 1] = math.sqrt(variance)
