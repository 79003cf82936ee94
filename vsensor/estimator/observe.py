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
from vsensor.estimator.sections import Floats, Line
from vsensor.estimator.state import BIT, SPEED, TOP, TORQUE, Model, State
from vsensor.jit import compiled

REST_SPEED = 0.2
"""A string whose top turns more slowly than this (rad/s) at the start is taken to stand still."""
WILD = 5.0
"""An innovation beyond so many deviations counts as one of so many (Huber 1964)."""
SURPRISE_S = 2.0
"""Time over which the innovations' size is judged."""


@compiled
def line_of(model: Model, which: int) -> Line:
    """One of the strings: the model's own is the first."""
    line = model.line
    return Line(
        model.impedances[which],
        model.round_trips[which],
        line.viscous,
        line.kinetic,
        line.static,
        line.depth,
    )


@compiled
def settle(model: Model, state: State, which: int, torque: float, speed: float) -> None:
    """Lay the waves of a string that has long turned, or stood, under this motor torque and speed."""
    line = line_of(model, which)
    t, w = torque * model.passed, speed / model.turns
    if abs(w) < REST_SPEED:
        w = 0.0
    t -= rubbing(line, 0, w)
    for i in range(line.impedance.shape[0]):
        state.waves[which, i, :] = t + line.impedance[i] * w
        t -= rubbing(line, i + 1, w)
    state.junctions[which, :] = w
    state.balances[which, :] = 0.0
    load = load_in_force(state.learned, model.bit_rate)
    state.rock[which] = t - law(load, w) if w != 0 else 0.0


@compiled
def observe(model: Model, state: State, which: int) -> None:
    """Run one string by the internal steps of this tick, whose input has been entered, and correct it.

    The waves that come back are kept for the model string alone: nobody looks along a shadow.
    """
    line = line_of(model, which)
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
        _turn(model, state, which, line, step, torque * model.passed, speed / model.turns, silent)
        if which == 0:
            keep_returned(line, state.waves[0], state.junctions[0], step, state.returned)
    state.innovation[which] = math.nan
    if not silent and state.missing[SPEED, place] == 0:
        innovation = _tamed(
            model, state, which, inputs[SPEED, place] / model.turns - state.junctions[which, 0]
        )
        state.innovation[which] = innovation
        _correct(model, state, which, innovation)
        _correct_waves(model, state, model.gains.waves, state.waves[which], innovation)
        if which == 0:
            _correct_waves(model, state, model.gains.returned, state.returned, innovation)


@compiled
def _turn(
    model: Model, state: State, which: int, line: Line, step: int, torque: float, speed: float, silent: bool
) -> None:
    """One internal step of a string, by torque, or by speed where torque is silent."""
    mask = state.told.shape[2] - 1
    waves, junctions, told = state.waves[which], state.junctions[which], state.told[which]
    balances = state.balances[which]
    state.rock[which] *= model.fade
    g, balances[BIT] = march(
        line,
        load_in_force(state.learned, model.bit_rate),
        waves,
        step - 1,
        1,
        step - 1,
        EVERY_JUNCTION,
        state.rock[which],
        1.0,
        junctions,
        balances[BIT],
        state.ahead,
    )
    drive_rate = model.drive_rates[which]
    if silent:
        w = speed
        balances[TOP] = 0.5 * drive_rate * (w - junctions[0])
    else:
        w, balances[TOP] = turn_top(line, drive_rate, torque - g, junctions[0], balances[TOP])
    junctions[0] = w
    z = line.impedance[0]
    now = step & mask
    waves[0, now] = g + 2 * z * w
    told[TOLD_BIT_SPEED, now] = state.ahead[0, 0]
    told[TOLD_BIT_TORQUE, now] = state.ahead[1, 0]
    told[TOLD_TOP_SPEED, now] = w
    told[TOLD_TOP_TORQUE, now] = g + z * w + rubbing(line, 0, w)


@compiled
def note_rest(model: Model, state: State) -> None:
    """Note how much of the torque resting parts of the wall may hold at this tick."""
    held = 0.0
    for junction in range(state.junctions.shape[1]):
        if state.junctions[0, junction] == 0:
            held += model.line.static[junction]
    state.held[state.ticks[0] % state.held.shape[0]] = held


@compiled
def _tamed(model: Model, state: State, which: int, innovation: float) -> float:
    """An innovation held within what can be believed; keeps count of how large they are."""
    expected = model.gains.innovation[state.level[0]]
    limit = WILD * math.sqrt(expected * max(1.0, state.surprise[which]))
    tamed = min(max(innovation, -limit), limit)
    state.surprise[which] += (tamed * tamed / expected - state.surprise[which]) / (SURPRISE_S * model.rate)
    return tamed


@compiled
def _correct(model: Model, state: State, which: int, innovation: float) -> None:
    """Correct the bit, the rock, and the answers of the last `lag` ticks. What rests stays at rest."""
    gains, level = model.gains, state.level[0]
    junctions, told, balances = state.junctions[which], state.told[which], state.balances[which]
    if junctions[0] != 0:
        junctions[0] += gains.state[level, TOP_SPEED] * innovation
        balances[TOP] += gains.state[level, TOP_BALANCE] * innovation
    bit = junctions.shape[0] - 1
    if junctions[bit] != 0:
        junctions[bit] += gains.state[level, BIT_SPEED] * innovation
        balances[BIT] += gains.state[level, BIT_BALANCE] * innovation
    state.rock[which] += gains.state[level, ROCK] * innovation
    mask = told.shape[1] - 1
    last = state.ticks[0] * model.steps + model.steps - 1
    for ago in range(gains.told.shape[2]):
        at = (last - ago) & mask
        if told[TOLD_BIT_SPEED, at] != 0:
            told[TOLD_BIT_SPEED, at] += gains.told[level, TOLD_BIT_SPEED, ago] * innovation
            told[TOLD_BIT_TORQUE, at] += gains.told[level, TOLD_BIT_TORQUE, ago] * innovation
        told[TOLD_TOP_SPEED, at] += gains.told[level, TOLD_TOP_SPEED, ago] * innovation
        told[TOLD_TOP_TORQUE, at] += gains.told[level, TOLD_TOP_TORQUE, ago] * innovation


@compiled
def _correct_waves(
    model: Model, state: State, of_innovation: Floats, waves: Floats, innovation: float
) -> None:
    """Correct waves (M, size) of the last `lag` ticks by an innovation times gains (C, M, L)."""
    mask = waves.shape[1] - 1
    last = state.ticks[0] * model.steps + model.steps - 1
    for i in range(waves.shape[0]):
        for ago in range(of_innovation.shape[2]):
            waves[i, (last - ago) & mask] += of_innovation[state.level[0], i, ago] * innovation
