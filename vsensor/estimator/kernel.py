"""One tick of the estimator, compiled: take the input, confirm, score, march, answer. No allocation."""

import math

import numpy as np
from numpy.typing import NDArray

from vsensor.estimator.ahead import predict
from vsensor.estimator.confirm import confirm
from vsensor.estimator.learn import learn, lose_sight
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import FLAGS, Model, State
from vsensor.jit import compiled
from vsensor.quality import Reason

CONFIRMED, NOW, FORECAST = 0, 4, 8
"""Where each answer starts in a row of output: speed, its deviation, torque, its deviation."""
SPEED, SPEED_STD, TORQUE, TORQUE_STD = range(4)
COLUMNS = 12

_WARMING_UP = int(Reason.WARMING_UP)
_STALE_TORQUE = int(Reason.STALE_TORQUE)
_STALE_SPEED = int(Reason.STALE_SPEED)
_NOT_MEASURED = _WARMING_UP | _STALE_TORQUE | _STALE_SPEED


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
    """Run n ticks: inputs (n,), `out` (n, COLUMNS) and `out_reasons` (n,) are filled.

    An input that is not finite counts as missing: the last one is held, and flagged.
    """
    for k in range(torque.shape[0]):
        flags = _enter(state, torque[k], speed[k], reasons[k])
        out_reasons[k] = _lasting(model, state, flags)
        confirm(model, state)
        if not out_reasons[k] & _NOT_MEASURED:
            _score(model, state)
        if out_reasons[k]:
            lose_sight(state.learned)
        elif model.learns:
            _learn(model, state)
        predict(model, state)
        _answer(model, state, out_reasons[k], out[k])
        state.ticks[0] += 1


@compiled
def _enter(state: State, torque: float, speed: float, reasons: int) -> int:
    width = state.torque.shape[0] // 2
    tick = state.ticks[0]
    before = (tick - 1) % width
    flags = int(reasons)
    if not math.isfinite(torque):
        torque = state.torque[before]
        flags |= _STALE_TORQUE
    if not math.isfinite(speed):
        speed = state.speed[before]
        flags |= _STALE_SPEED
    place = tick % width
    state.torque[place] = state.torque[place + width] = torque
    state.speed[place] = state.speed[place + width] = speed
    return flags


@compiled
def _lasting(model: Model, state: State, flags: int) -> int:
    """Flags of the confirmed answer: all that were raised on any input that takes part in it."""
    tick = state.ticks[0]
    lasting = _WARMING_UP if tick < model.span else 0
    for bit in range(FLAGS):
        if flags >> bit & 1:
            state.last_seen[bit] = tick
        if tick - state.last_seen[bit] < model.span:
            lasting |= 1 << bit
    return lasting


@compiled
def _learn(model: Model, state: State) -> None:
    mask = state.waves.shape[1] - 1
    newest = state.ticks[0] * model.steps + model.steps - 1
    speed, torque = state.confirmed[0, newest & mask], state.confirmed[1, newest & mask]
    learn(state.learned, model.line, state.junctions, speed, torque, model.rate, state.ticks[0])


@compiled
def _score(model: Model, state: State) -> None:
    """Hold what was foretold against what is confirmed by now."""
    mask = state.waves.shape[1] - 1
    newest = state.ticks[0] * model.steps + model.steps - 1
    for kind in range(2):
        ahead = model.now if kind == 0 else model.forecast
        # Only one step of this tick was foretold from the last step of a tick.
        tick = (newest - ahead + 1) // model.steps - 1
        step = tick * model.steps + model.steps - 1 + ahead
        if tick < model.span:
            continue
        place = tick % state.foretold.shape[2]
        state.scored[kind] += 1
        gain = 1.0 / min(state.scored[kind], model.memory)
        for q in range(2):
            miss = state.foretold[kind, q, place] - state.confirmed[q, step & mask]
            state.errors[kind, q] += gain * (miss * miss - state.errors[kind, q])


@compiled
def _answer(model: Model, state: State, reasons: int, out: Floats) -> None:
    """Fill a row with what is known and how well; what has no known deviation is not told."""
    out[:] = math.nan
    if reasons & _WARMING_UP:
        return
    by_law = reasons & (_STALE_TORQUE | _STALE_SPEED) != 0
    newest = (state.ticks[0] * model.steps + model.steps - 1) & (state.waves.shape[1] - 1)
    place = state.ticks[0] % state.foretold.shape[2]
    for q in range(2):
        noise = model.speed_std if q == 0 else model.torque_std
        if not by_law:
            _tell(out, CONFIRMED + 2 * q, state.confirmed[q, newest], noise * noise)
        elif state.scored[0] > 0:
            _tell(out, CONFIRMED + 2 * q, state.confirmed[q, newest], noise * noise + state.errors[0, q])
        for kind in range(2):
            if state.scored[kind] > 0:
                # Without a measured bit to set out from, that one's error comes on top.
                times = 2.0 if by_law else 1.0
                at = (NOW if kind == 0 else FORECAST) + 2 * q
                _tell(out, at, state.foretold[kind, q, place], times * state.errors[kind, q])


@compiled
def _tell(out: Floats, at: int, value: float, variance: float) -> None:
    out[at] = value
    out[at + 1] = math.sqrt(variance)
