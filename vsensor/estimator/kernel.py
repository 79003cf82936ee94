"""One tick of the estimator, compiled: take the input, observe, score, learn, march, answer."""

import math

import numpy as np
from numpy.typing import NDArray

from vsensor.estimator.ahead import predict, stick_ahead
from vsensor.estimator.learn import lose_sight
from vsensor.estimator.observe import note_rest, observe, settle
from vsensor.estimator.responses import TOLD_BIT_TORQUE, TOLD_TOP_SPEED
from vsensor.estimator.score import FORECAST as LAST
from vsensor.estimator.score import HORIZONS, VALUE, foretell, score, variance
from vsensor.estimator.score import NOW as FIRST
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import FLAGS, NONE, Model, State
from vsensor.estimator.study import confirmed_step, foretold_for, study_rock, study_string, study_wall
from vsensor.estimator.tune import (
    DELAY,
    FRICTION,
    INERTIA,
    OFFSET,
    SETTLED_S,
    STRINGS,
    wall_torque,
)
from vsensor.jit import compiled
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
_STALE_TORQUE = int(Reason.STALE_TORQUE)
_STALE_SPEED = int(Reason.STALE_SPEED)
_STALE = _STALE_TORQUE | _STALE_SPEED
_NOT_MEASURED = _WARMING_UP | _STALE


@compiled
def advance(
    model: Model,
    state: State,
    torque: Floats,
    speed: Floats,
    reasons: NDArray[np.uint32],
    out: Floats,
    out_reasons: NDArray[np.uint32],
) -> None:
    """Run n ticks: inputs (n,), `out` (n, COLUMNS) and `out_reasons` (n,) are filled. No allocation.

    `reasons` (n,) holds flags of `quality.Reason`, OFF_BOTTOM and NO_FORECAST. An input that is not finite,
    or beyond belief, counts as missing: the last one is held, and flagged.
    """
    for k in range(torque.shape[0]):
        flags = _enter(model, state, torque[k], speed[k], reasons[k])
        _follow_bit(model, state, reasons[k] & OFF_BOTTOM != 0)
        if state.ticks[0] == 0 or state.surprise[0] > LOST:
            _lay(model, state)
        out_reasons[k] = _lasting(model, state, flags)
        for which in range(STRINGS):
            observe(model, state, which)
        note_rest(model, state)
        if not out_reasons[k] & _NOT_MEASURED:
            _score(model, state)
        if out_reasons[k]:
            lose_sight(state.learned)
        elif state.off_bottom[0] > 0:
            study_wall(model, state)
        else:
            study_rock(model, state)
        if not out_reasons[k] and (state.ticks[0] > SETTLED_S * model.rate or not model.learns):
            study_string(model, state)
        kinds = FIRST + 1 if reasons[k] & NO_FORECAST else HORIZONS
        predict(model, state, model.horizons[kinds - 1])
        _foretell(model, state, kinds)
        _answer(model, state, out_reasons[k], kinds, out[k])
        if not out_reasons[k] & _WARMING_UP:
            _answer_top(model, state, out[k])
        state.ticks[0] += 1


@compiled
def _enter(model: Model, state: State, torque: float, speed: float, reasons: int) -> int:
    flags = int(reasons) & (OFF_BOTTOM - 1)
    if not abs(torque) <= model.limits[0]:
        flags |= _STALE_TORQUE
    if not abs(speed) <= model.limits[1]:
        flags |= _STALE_SPEED
    offset = state.tuning.value[OFFSET] / model.passed
    _keep(state, 0, torque - offset, flags & _STALE_TORQUE != 0)
    _keep(state, 1, speed, flags & _STALE_SPEED != 0)
    return flags


@compiled
def _lay(model: Model, state: State) -> None:
    """Lay the waves of all strings as of steady rotation, at the start or where they have gone astray."""
    place = state.ticks[0] % state.inputs.shape[1]
    for which in range(STRINGS):
        settle(model, state, which, state.inputs[0, place], state.inputs[1, place])
    state.surprise[:] = 1.0
    state.course[:] = NONE
    state.ticks[1] = state.ticks[0]


@compiled
def _follow_bit(model: Model, state: State, off: bool) -> None:
    """Count since when the bit has been off bottom; the model's own is a travel time behind."""
    count = state.off_bottom[0]
    state.off_bottom[0] = max(count, 0) + 1 if off else min(count, 0) - 1
    if state.ticks[0] == 0 or abs(state.off_bottom[0]) * model.steps >= model.now:
        state.learned.idle[0] = 1 if off else 0


@compiled
def _keep(state: State, channel: int, value: float, missing: bool) -> None:
    """Enter a sample; the last one again where it is missing, the first one as if it had long been so."""
    width = state.inputs.shape[1]
    place = state.ticks[0] % width
    state.missing[channel, place] = 1 if missing else 0
    if channel == 0:
        state.motor[:, place] = 0.0
    if missing:
        state.inputs[channel, place] = state.inputs[channel, (place - 1) % width]
    elif state.ticks[0] == 0:
        state.inputs[channel, :] = value
    else:
        state.inputs[channel, place] = value


@compiled
def _lasting(model: Model, state: State, flags: int) -> int:
    """Flags of the confirmed answer: all that were raised on any input that takes part in it."""
    tick = state.ticks[0]
    lasting = _WARMING_UP if tick - state.ticks[1] < model.span else 0
    for bit in range(FLAGS):
        if flags >> bit & 1:
            state.last_seen[bit] = tick
        if tick - state.last_seen[bit] < model.span:
            lasting |= 1 << bit
    return lasting


@compiled
def _doubt(model: Model, state: State, quantity: int, step: int) -> float:
    """Variance of a confirmed answer: by noise and rock, and by what is uncertain of the parameters."""
    mask = state.told.shape[2] - 1
    by_noise = model.gains.variance[state.level[0], quantity] * max(1.0, state.surprise[0])
    # With longer delays the bit of a moment is seen later.
    longer = state.told[1, quantity, (step + model.shift) & mask]
    shorter = state.told[2, quantity, (step - model.shift) & mask]
    heavier, lighter = state.told[3, quantity, step & mask], state.told[4, quantity, step & mask]
    unsure = state.tuning.variance
    by_parameters = unsure[DELAY] * ((longer - shorter) / (2.0 * model.off[DELAY])) ** 2
    by_parameters += unsure[INERTIA] * ((heavier - lighter) / (2.0 * model.off[INERTIA])) ** 2
    if quantity == TOLD_BIT_TORQUE:
        # The wall's own speed is the top's at least on average: it rubs where the bit rests.
        top = step - (model.now - model.behind * model.steps)
        wall = wall_torque(model.line, state.told[0, TOLD_TOP_SPEED, top & mask])
        by_parameters += (unsure[FRICTION] * wall + 2.0 * state.tuning.shared[0]) * wall + unsure[OFFSET]
        # Parts of the wall that rest hold anything up to their static friction: all of it is equally likely.
        held = state.held[(state.ticks[0] - model.lag) % state.held.shape[0]]
        by_parameters += held * held / 3.0
    return float(by_noise + by_parameters)


@compiled
def _score(model: Model, state: State) -> None:
    """Hold what was foretold against what is confirmed by now."""
    mask = state.told.shape[2] - 1
    width = state.scores.foretold.shape[3]
    for kind in range(HORIZONS):
        tick, step = foretold_for(model, state, kind)
        # Nothing was foretold while warming up or short of time, nor of a string that was made longer since.
        if tick < model.span or math.isnan(state.scores.foretold[kind, 0, VALUE, tick % width]):
            continue
        state.scores.scored[kind] += 1
        for q in range(2):
            score(state.scores, kind, q, tick, state.told[0, q, step & mask], model.rate)


@compiled
def _foretell(model: Model, state: State, kinds: int) -> None:
    """Note what the march says of the first horizons, and the gains' variance for this rock."""
    level = state.level[0]
    restless = state.rock_square[0] / model.gains.levels[level] ** 2
    lasting = max(1, int(CHANGE_S * model.rate * model.steps))
    tick = state.ticks[0]
    known = tick * model.steps + model.steps - 1
    state.scores.foretold[kinds:, :, VALUE, tick % state.scores.foretold.shape[3]] = math.nan
    for kind in range(kinds):
        for q in range(2):
            state.unforeseen[q] = restless * model.gains.unforeseen[level, kind, q]
        steps = model.horizons[kind]
        foretell(state.scores, kind, tick, state.ahead, known, steps, lasting, state.unforeseen)


@compiled
def _answer(model: Model, state: State, reasons: int, kinds: int, out: Floats) -> None:
    """Fill a row with what is known and how well; what has no known deviation is not told."""
    out[:] = math.nan
    if reasons & _WARMING_UP:
        return
    if kinds == HORIZONS:
        out[STICK] = stick_ahead(model, state)
    by_law = reasons & _STALE != 0
    confirmed = confirmed_step(model, state)
    place = state.ticks[0] % state.scores.foretold.shape[3]
    for q in range(2):
        doubt = _doubt(model, state, q, confirmed)
        if by_law:
            doubt += variance(state.scores, FIRST, q, state.scores.foretold[FIRST, q, :, place])
        if not by_law or state.scores.scored[FIRST] > 0:
            _tell(out, CONFIRMED + 2 * q, state.told[0, q, confirmed & (state.told.shape[2] - 1)], doubt)
        for kind, at in ((FIRST, NOW), (LAST, FORECAST)):
            if kind < kinds and state.scores.scored[kind] > 0:
                foretold = state.scores.foretold[kind, q, :, place]
                missed = variance(state.scores, kind, q, foretold)
                # What was foretold was held against a confirmed answer that is not exact itself.
                _tell(out, at + 2 * q, foretold[VALUE], missed + doubt)


@compiled
def _answer_top(model: Model, state: State, out: Floats) -> None:
    """The string's top at the time that is confirmed of the bit, and what noise and offset leave of doubt."""
    step = confirmed_step(model, state) - (model.now - model.behind * model.steps)
    at = step & (state.told.shape[2] - 1)
    for q in range(2):
        doubt = model.gains.variance[state.level[0], 2 + q] * max(1.0, state.surprise[0])
        if q == 1:
            doubt += state.tuning.variance[OFFSET]
        _tell(out, TOP + 2 * q, state.told[0, 2 + q, at], doubt)


@compiled
def _tell(out: Floats, at: int, value: float, variance: float) -> None:
    out[at] = value
    out[at + 1] = math.sqrt(variance)
