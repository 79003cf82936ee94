"""The string observed: a model runs under the motor's torque, and each innovation of speed corrects it.

All that can be wrong of the model string, its waves, the bit and the rock, is corrected by gains that
weigh noise against rock (gains.py), for the present and for `lag` ticks back. Where one channel is
silent the same string runs on under the other alone:

    torque known     J dω/dt = T_motor − T_string, T_string = g + ζω
    speed known      f = g + 2ζω
"""

import math

from vsensor.estimator.along import keep_returned
from vsensor.estimator.gains import (
    BIT_BALANCE,
    BIT_SPEED,
    ROCK,
    TOLD_BIT_SPEED,
    TOLD_BIT_TORQUE,
    TOLD_TOP_SPEED,
    TOLD_TOP_TORQUE,
    TOP_BALANCE,
    TOP_SPEED,
)
from vsensor.estimator.learn import load_in_force
from vsensor.estimator.line import EVERY_JUNCTION, march, rubbing, turn_top
from vsensor.estimator.load import law
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import BIT, SPEED, TOP, TORQUE, Model, State
from vsensor.jit import compiled

REST_SPEED = 0.2
"""A string whose top turns more slowly than this (rad/s) at the start is taken to stand still."""
WILD = 5.0
"""An innovation beyond so many deviations counts as one of so many (Huber 1964)."""
SURPRISE_S = 2.0
"""Time over which the innovations' size is judged."""


@compiled
def settle(model: Model, state: State, torque: float, speed: float) -> None:
    """Lay the waves of a string that has long turned, or stood, under this motor torque and speed."""
    line = model.line
    t, w = torque * model.passed, speed / model.turns
    if abs(w) < REST_SPEED:
        w = 0.0
    t -= rubbing(line, 0, w)
    for i in range(line.impedance.shape[0]):
        state.waves[i, :] = t + line.impedance[i] * w
        t -= rubbing(line, i + 1, w)
    state.junctions[:] = w
    state.balances[:] = 0.0
    state.rock[0] = t - law(load_in_force(state.learned, model.bit_rate), w) if w != 0 else 0.0


@compiled
def observe(model: Model, state: State, keeps: bool) -> None:
    """Run the internal steps of this tick, whose input has been entered, and correct.

    The waves that come back are kept only where somebody looks along the string (`keeps`).
    """
    inputs = state.inputs
    width = inputs.shape[1]
    place = (state.ticks[0] - model.behind) % width
    before = (place - 1) % width
    whole = int(model.late)
    # The torque of a step is told `late` ticks afterwards, between two samples.
    early, then = (place + whole - 1) % width, (place + whole) % width
    after = (place + min(whole + 1, model.behind)) % width
    silent = state.missing[TORQUE, early] + state.missing[TORQUE, then] + state.missing[TORQUE, after] > 0
    for row in range(model.steps):
        share = (row + 1) / model.steps
        speed = inputs[SPEED, before] + share * (inputs[SPEED, place] - inputs[SPEED, before])
        at = share + model.late - whole
        if at <= 1.0:
            torque = inputs[TORQUE, early] + at * (inputs[TORQUE, then] - inputs[TORQUE, early])
        else:
            torque = inputs[TORQUE, then] + (at - 1.0) * (inputs[TORQUE, after] - inputs[TORQUE, then])
        step = state.ticks[0] * model.steps + row
        _turn(model, state, step, torque * model.passed, speed / model.turns, silent)
        if keeps:
            keep_returned(model.line, state.waves, state.junctions, step, state.returned)
    _note_rest(state, model)
    state.innovation[0] = math.nan
    if not silent and state.missing[SPEED, place] == 0:
        state.innovation[0] = _tamed(model, state, inputs[SPEED, place] / model.turns - state.junctions[0])
        _correct(model, state, state.innovation[0])
        if keeps:
            _correct_waves(model, state, model.gains.returned, state.returned, state.innovation[0])


@compiled
def _turn(model: Model, state: State, step: int, torque: float, speed: float, silent: bool) -> None:
    """One internal step of the string, by torque, or by speed where torque is silent."""
    mask = state.waves.shape[1] - 1
    line = model.line
    state.rock[0] *= model.fade
    g, state.balances[BIT] = march(
        line,
        load_in_force(state.learned, model.bit_rate),
        state.waves,
        step - 1,
        1,
        step - 1,
        EVERY_JUNCTION,
        state.rock[0],
        1.0,
        state.junctions,
        state.balances[BIT],
        state.ahead,
    )
    if silent:
        w = speed
        state.balances[TOP] = 0.5 * model.drive_rate * (w - state.junctions[0])
    else:
        w, state.balances[TOP] = turn_top(
            line, model.drive_rate, torque - g, state.junctions[0], state.balances[TOP]
        )
    state.junctions[0] = w
    z = line.impedance[0]
    now = step & mask
    state.waves[0, now] = g + 2 * z * w
    state.told[TOLD_BIT_SPEED, now] = state.ahead[0, 0]
    state.told[TOLD_BIT_TORQUE, now] = state.ahead[1, 0]
    state.told[TOLD_TOP_SPEED, now] = w
    state.told[TOLD_TOP_TORQUE, now] = g + z * w + rubbing(line, 0, w)


@compiled
def _note_rest(state: State, model: Model) -> None:
    held = 0.0
    for junction in range(state.junctions.shape[0]):
        if state.junctions[junction] == 0:
            held += model.line.static[junction]
    state.held[state.ticks[0] % state.held.shape[0]] = held


@compiled
def _tamed(model: Model, state: State, innovation: float) -> float:
    """An innovation held within what can be believed; keeps count of how large they are."""
    expected = model.gains.innovation[state.level[0]]
    limit = WILD * math.sqrt(expected * max(1.0, state.surprise[0]))
    tamed = min(max(innovation, -limit), limit)
    state.surprise[0] += (tamed * tamed / expected - state.surprise[0]) / (SURPRISE_S * model.rate)
    return tamed


@compiled
def _correct(model: Model, state: State, innovation: float) -> None:
    """Correct string, bit and rock, and the answers of the last `lag` ticks. What rests stays at rest."""
    gains, level = model.gains, state.level[0]
    mask = state.waves.shape[1] - 1
    last = state.ticks[0] * model.steps + model.steps - 1
    if state.junctions[0] != 0:
        state.junctions[0] += gains.state[level, TOP_SPEED] * innovation
        state.balances[TOP] += gains.state[level, TOP_BALANCE] * innovation
    bit = state.junctions.shape[0] - 1
    if state.junctions[bit] != 0:
        state.junctions[bit] += gains.state[level, BIT_SPEED] * innovation
        state.balances[BIT] += gains.state[level, BIT_BALANCE] * innovation
    state.rock[0] += gains.state[level, ROCK] * innovation
    _correct_waves(model, state, gains.waves, state.waves, innovation)
    for ago in range(gains.told.shape[2]):
        at = (last - ago) & mask
        if state.told[TOLD_BIT_SPEED, at] != 0:
            state.told[TOLD_BIT_SPEED, at] += gains.told[level, TOLD_BIT_SPEED, ago] * innovation
            state.told[TOLD_BIT_TORQUE, at] += gains.told[level, TOLD_BIT_TORQUE, ago] * innovation
        state.told[TOLD_TOP_SPEED, at] += gains.told[level, TOLD_TOP_SPEED, ago] * innovation
        state.told[TOLD_TOP_TORQUE, at] += gains.told[level, TOLD_TOP_TORQUE, ago] * innovation


@compiled
def _correct_waves(
    model: Model, state: State, of_innovation: Floats, waves: Floats, innovation: float
) -> None:
    mask = waves.shape[1] - 1
    last = state.ticks[0] * model.steps + model.steps - 1
    for i in range(waves.shape[0]):
        for ago in range(of_innovation.shape[2]):
            waves[i, (last - ago) & mask] += of_innovation[state.level[0], i, ago] * innovation
