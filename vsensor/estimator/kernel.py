"""One tick of the estimator, compiled: window, top drive, descent, march, score. No allocation."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.estimator.line import REST_SPEED, descend, march
from vsensor.estimator.load import Load, foot, turning
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.estimator.top_drive import Smoother, string_top
from vsensor.jit import compiled
from vsensor.quality import Reason

CONFIRMED, NOW, FORECAST = 0, 4, 8
"""Where each answer starts in a row of output: speed, its deviation, torque, its deviation."""
SPEED, SPEED_STD, TORQUE, TORQUE_STD = range(4)
COLUMNS = 12
SPEED_OF, TORQUE_OF = range(2)
"""Rows of what is remembered of the bit."""

_WARMING_UP = int(Reason.WARMING_UP)
_STALE_TORQUE = int(Reason.STALE_TORQUE)
_STALE_SPEED = int(Reason.STALE_SPEED)
_BEYOND_HORIZON = int(Reason.BEYOND_HORIZON)
FLAGS = 16


class Model(NamedTuple):
    """What does not change while running. Times in internal steps, `steps` of which make a tick."""

    line: Line
    load: Load
    smooth: Smoother
    steps: int
    now: int
    """From a confirmed step to the present: the smoother's lag and the line's one-way delay."""
    forecast: int
    """From a confirmed step to the last that the waves in the string reach: the line's round trip."""
    span: int
    """Ticks for which an input takes part in the confirmed answer."""
    memory: int
    """Ticks over which a prediction's running error forgets."""
    speed_std: float
    torque_std: float


class State(NamedTuple):
    """What changes from tick to tick; plain arrays, so that saving it is copying them."""

    torque: Floats
    """Motor torque, the window of the smoother written twice over, so that it is always in one piece."""
    speed: Floats
    waves: Floats
    junctions: Floats
    """Speed of each junction at the last confirmed step."""
    confirmed: Floats
    """Bit speed and torque by internal step, a ring as long as that of the waves, shape (2, size)."""
    foretold: Floats
    """What each tick said of now and of the forecast, a ring, shape (2, 2, ticks)."""
    errors: Floats
    """Running mean square error of now and forecast, of speed and torque, shape (2, 2)."""
    counts: Integers
    """Ticks done, then predictions scored of now and of the forecast."""
    last_seen: Integers
    """The last tick at which each flag was raised."""
    marching: Floats
    """Room for the march: each junction's speed,"""
    told: Floats
    """and the bit's speed and torque at each of its steps, shape (2, steps)."""


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
        _confirm(model, state)
        out_reasons[k] = _lasting(model, state, flags)
        _score(model, state, out_reasons[k])
        _predict(model, state)
        _answer(model, state, out_reasons[k], out[k])
        state.counts[0] += 1


@compiled
def _enter(state: State, torque: float, speed: float, reasons: int) -> int:
    width = state.torque.shape[0] // 2
    tick = state.counts[0]
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
def _confirm(model: Model, state: State) -> None:
    width = state.torque.shape[0] // 2
    oldest = (state.counts[0] + 1) % width
    torque = state.torque[oldest : oldest + width]
    speed = state.speed[oldest : oldest + width]
    mask = state.waves.shape[1] - 1
    inertia = 0.5 * model.load.inertia_rate
    for row in range(model.steps):
        step = state.counts[0] * model.steps + row
        t, w = string_top(model.smooth, row, torque, speed)
        t, w = descend(model.line, state.waves, state.junctions, step, t, w)
        state.confirmed[0, step & mask] = w
        state.confirmed[1, step & mask] = t - inertia * (w - state.confirmed[0, (step - 1) & mask])


@compiled
def _lasting(model: Model, state: State, flags: int) -> int:
    """Flags of the confirmed answer: all that were raised on any input that takes part in it."""
    tick = state.counts[0]
    lasting = _WARMING_UP if tick < model.span else 0
    for bit in range(FLAGS):
        if flags >> bit & 1:
            state.last_seen[bit] = tick
        if tick - state.last_seen[bit] < model.span:
            lasting |= 1 << bit
    if model.now > model.forecast:
        lasting |= _BEYOND_HORIZON
    return lasting


@compiled
def _score(model: Model, state: State, reasons: int) -> None:
    """Hold what was foretold against what is confirmed by now."""
    if reasons & ~_BEYOND_HORIZON:
        return
    mask = state.waves.shape[1] - 1
    newest = state.counts[0] * model.steps + model.steps - 1
    for kind in range(2):
        ahead = model.now if kind == 0 else max(model.now, model.forecast)
        # Only one step of this tick was foretold from the last step of a tick.
        tick = (newest - ahead + 1) // model.steps - 1
        step = tick * model.steps + model.steps - 1 + ahead
        place = tick % state.foretold.shape[2]
        if tick < model.span or not math.isfinite(state.foretold[kind, 0, place]):
            continue
        state.counts[1 + kind] += 1
        gain = 1.0 / min(state.counts[1 + kind], model.memory)
        for q in range(2):
            miss = state.foretold[kind, q, place] - state.confirmed[q, step & mask]
            state.errors[kind, q] += gain * (miss * miss - state.errors[kind, q])


@compiled
def _predict(model: Model, state: State) -> None:
    """March the waves in the string on to now and to the forecast."""
    known = state.counts[0] * model.steps + model.steps - 1
    last = model.line.impedance.shape[0] - 1
    for junction in range(last + 2):
        w = state.junctions[junction]
        state.marching[junction] = w if abs(w) > REST_SPEED else 0.0
    f = state.waves[last, (known - model.line.round_trip[last]) & (state.waves.shape[1] - 1)]
    balance = turning(model.load, foot(model.line), f, state.marching[last + 1])
    end = max(model.now, model.forecast)
    march(model.line, model.load, state.waves, known, end, end, 0.0, state.marching, balance, state.told)
    place = state.counts[0] % state.foretold.shape[2]
    for q in range(2):
        state.foretold[0, q, place] = state.told[q, model.now - 1]
        state.foretold[1, q, place] = state.told[q, end - 1]


@compiled
def _answer(model: Model, state: State, reasons: int, out: Floats) -> None:
    out[:] = math.nan
    if reasons & _WARMING_UP:
        return
    newest = (state.counts[0] * model.steps + model.steps - 1) & (state.waves.shape[1] - 1)
    out[CONFIRMED + SPEED] = state.confirmed[SPEED_OF, newest]
    out[CONFIRMED + SPEED_STD] = model.speed_std
    out[CONFIRMED + TORQUE] = state.confirmed[TORQUE_OF, newest]
    out[CONFIRMED + TORQUE_STD] = model.torque_std
    place = state.counts[0] % state.foretold.shape[2]
    for kind in range(2):
        # A prediction that was never scored has no known deviation, so it is not told.
        if state.counts[1 + kind] > 0:
            at = NOW if kind == 0 else FORECAST
            out[at + SPEED] = state.foretold[kind, SPEED_OF, place]
            out[at + SPEED_STD] = math.sqrt(state.errors[kind, SPEED_OF])
            out[at + TORQUE] = state.foretold[kind, TORQUE_OF, place]
            out[at + TORQUE_STD] = math.sqrt(state.errors[kind, TORQUE_OF])
