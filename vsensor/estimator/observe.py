"""The string observed: a model runs under the motor's torque, and each innovation of speed corrects it.

All that can be wrong of the model string, its waves, the bit and the rock, is corrected by gains that
weigh noise against rock (gains.py), for the present and for `lag` ticks back. Where one channel is
silent the same string runs on under the other alone:

    torque known     J dω/dt = T_motor − T_string, T_string = g + ζω
    speed known      f = g + 2ζω
"""

import math

from vsensor.estimator.along import keep_returned
from vsensor.estimator.gains import Gains
from vsensor.estimator.learn import load_in_force
from vsensor.estimator.line import march, rubbing, turn_top
from vsensor.estimator.load import Load, law
from vsensor.estimator.responses import (
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
from vsensor.estimator.score import VALUE
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.estimator.state import BIT, SPEED, TOP, TORQUE, Model, State, Strand, line_of, strand
from vsensor.jit import compiled

REST_SPEED = 0.2
"""A string whose top turns more slowly than this (rad/s) at the start is taken to stand still."""
WILD = 5.0
"""An innovation beyond so many deviations counts as one of so many (Huber 1964)."""
SURPRISE_S = 2.0
"""Time over which the innovations' size is judged."""


@compiled
def settle(model: Model, state: State, which: int, torque: float, speed: float) -> None:
    """Lay the waves of a string that has long turned, or stood, under this motor torque and speed."""
    line, string = line_of(model, which), strand(state, which)
    t, w = torque * model.passed, speed / model.turns
    if abs(w) < REST_SPEED:
        w = 0.0
    t -= rubbing(line, 0, w)
    for i in range(line.impedance.shape[0]):
        string.waves[i, :] = t + line.impedance[i] * w
        t -= rubbing(line, i + 1, w)
    string.junctions[:] = w
    string.balances[:] = 0.0
    load = load_in_force(state.learned, model.bit_rate)
    string.rock[0] = t - law(load, w) if w != 0 else 0.0


@compiled
def observe(model: Model, state: State, which: int) -> None:
    """Run one string by the internal steps of this tick, whose input has been entered, and correct it.

    The waves that come back are kept for the model string alone, and so is what corrects them (along.py):
    nobody looks along a shadow.
    """
    line, string = line_of(model, which), strand(state, which)
    load = load_in_force(state.learned, model.bit_rate)
    inputs = state.inputs
    width = inputs.shape[1]
    place = (state.ticks[0] - model.behind) % width
    before = (place - 1) % width
    silent = _torque_silent(model, state, place)
    for row in range(model.steps):
        share = (row + 1) / model.steps
        step = state.ticks[0] * model.steps + row
        string.rock[0] *= model.fade
        if silent:
            speed = inputs[SPEED, before] + share * (inputs[SPEED, place] - inputs[SPEED, before])
            turn_by_speed(line, load, model.drive_rates[which], string, step, speed / model.turns)
        else:
            torque = _torque_at(model, state, which, place, share)
            turn_by_torque(line, load, model.drive_rates[which], string, step, torque * model.passed)
        if which == 0:
            keep_returned(line, string.waves, string.junctions, step, state.returned)
    innovation = math.nan
    if not silent and state.missing[SPEED, place] == 0:
        innovation = _tamed(model, state, which, inputs[SPEED, place] / model.turns - string.junctions[0])
        _correct(model, state, which, place, innovation)
    state.innovation[which] = innovation
    if which == 0:
        past = state.ticks[0] % state.innovations.shape[0]
        state.innovations[past] = 0.0 if math.isnan(innovation) else innovation
        state.levels[past] = state.level[0]


@compiled
def _torque_silent(model: Model, state: State, place: int) -> bool:
    """Whether a torque sample is missing that this tick's steps, those of the sample at `place`, need."""
    width, whole = state.inputs.shape[1], int(model.late)
    early, then = (place + whole - 1) % width, (place + whole) % width
    after = (place + min(whole + 1, model.behind)) % width
    return bool(state.missing[TORQUE, early] + state.missing[TORQUE, then] + state.missing[TORQUE, after] > 0)


@compiled
def _torque_at(model: Model, state: State, which: int, place: int, share: float) -> float:
    """The motor's torque when such a share of this tick was over, told `late` ticks afterwards."""
    width, whole = state.inputs.shape[1], int(model.late)
    early, then = (place + whole - 1) % width, (place + whole) % width
    after = (place + min(whole + 1, model.behind)) % width
    at = share + model.late - whole
    one, other = (early, then) if at <= 1.0 else (then, after)
    between = at if at <= 1.0 else at - 1.0
    start = state.inputs[TORQUE, one] + state.motor[which, one]
    return float(start + between * (state.inputs[TORQUE, other] + state.motor[which, other] - start))


@compiled
def _correct(model: Model, state: State, which: int, place: int, innovation: float) -> None:
    """Correct all of a string, and what is held against the torques that are still to act."""
    gains, level, string = model.gains, state.level[0], strand(state, which)
    last = state.ticks[0] * model.steps + model.steps - 1
    correct_ends(gains, level, string, innovation)
    for ahead in range(model.behind + 1):
        at = (place + ahead) % state.motor.shape[1]
        state.motor[which, at] += gains.motor[level, ahead] * innovation / model.passed
    correct_told(gains.told[level], string.told, last, innovation)
    correct_waves(gains.waves[level], model.inside, string.waves, last, innovation)


@compiled
def turn_by_torque(
    line: Line, load: Load, drive_rate: float, string: Strand, step: int, torque: float
) -> None:
    """One internal step of a string whose top drive passes on `torque`."""
    g = _march_up(line, load, string, step)
    w, string.balances[TOP] = turn_top(
        line, drive_rate, torque - g, string.junctions[0], string.balances[TOP]
    )
    _send_down(line, string, step, g, w)


@compiled
def turn_by_speed(line: Line, load: Load, drive_rate: float, string: Strand, step: int, speed: float) -> None:
    """One internal step of a string whose top turns at `speed`, whatever torque that takes."""
    g = _march_up(line, load, string, step)
    string.balances[TOP] = 0.5 * drive_rate * (speed - string.junctions[0])
    _send_down(line, string, step, g, speed)


@compiled
def _march_up(line: Line, load: Load, string: Strand, step: int) -> float:
    now = step & (string.told.shape[1] - 1)
    g, string.balances[BIT] = march(
        line,
        load,
        string.waves,
        step,
        string.rock[0],
        string.junctions,
        string.balances[BIT],
        string.told,
        now,
    )
    return g


@compiled
def _send_down(line: Line, string: Strand, step: int, g: float, speed: float) -> None:
    z = line.impedance[0]
    now = step & (string.told.shape[1] - 1)
    string.junctions[0] = speed
    string.waves[0, now] = g + 2 * z * speed
    string.told[TOLD_TOP_SPEED, now] = speed
    string.told[TOLD_TOP_TORQUE, now] = g + z * speed + rubbing(line, 0, speed)


def shift_torque(model: Model, state: State, by: float) -> None:
    """Take an offset (N·m at the string) off all torques of before, as off those that are to come.

    A torque that is the same all along the string goes with any motion of it, so that nothing is stirred.
    """
    for torques in (state.waves, state.returned, state.rock):
        torques -= by
    state.inputs[TORQUE] -= by / model.passed
    state.told[:, [TOLD_BIT_TORQUE, TOLD_TOP_TORQUE]] -= by
    state.scores.foretold[:, TOLD_BIT_TORQUE, VALUE] -= by


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
def correct_ends(gains: Gains, level: int, string: Strand, innovation: float) -> None:
    """Correct top drive, bit and rock as they stand. What rests stays at rest."""
    junctions, balances = string.junctions, string.balances
    if junctions[0] != 0:
        junctions[0] += gains.state[level, TOP_SPEED] * innovation
        balances[TOP] += gains.state[level, TOP_BALANCE] * innovation
    bit = junctions.shape[0] - 1
    if junctions[bit] != 0:
        junctions[bit] += gains.state[level, BIT_SPEED] * innovation
        balances[BIT] += gains.state[level, BIT_BALANCE] * innovation
    string.rock[0] += gains.state[level, ROCK] * innovation


@compiled
def correct_told(of_innovation: Floats, told: Floats, last: int, innovation: float) -> None:
    """Correct the answers (4, size) of the steps up to `last` by gains (4, L). A bit that rested rested."""
    lag, size = of_innovation.shape[1], told.shape[1]
    done = 0
    while done < lag:
        at = (last + 1 - lag + done) & (size - 1)
        until = done + min(lag - done, size - at)
        end = at + until - done
        _correct_bit(
            of_innovation[TOLD_BIT_SPEED, done:until],
            of_innovation[TOLD_BIT_TORQUE, done:until],
            told[TOLD_BIT_SPEED, at:end],
            told[TOLD_BIT_TORQUE, at:end],
            innovation,
        )
        for of_top in (TOLD_TOP_SPEED, TOLD_TOP_TORQUE):
            _add(of_innovation[of_top, done:until], told[of_top, at:end], innovation)
        done = until


@compiled
def correct_waves(
    of_innovation: Floats, inside: Integers, waves: Floats, last: int, innovation: float
) -> None:
    """Correct waves (M, size) of the `inside` (M,) steps up to `last` by gains (M, L), newest last."""
    lag, size = of_innovation.shape[1], waves.shape[1]
    for i in range(waves.shape[0]):
        done = lag - min(inside[i], lag)
        while done < lag:
            at = (last + 1 - lag + done) & (size - 1)
            until = done + min(lag - done, size - at)
            _add(of_innovation[i, done:until], waves[i, at : at + until - done], innovation)
            done = until


@compiled
def _correct_bit(
    of_speed: Floats, of_torque: Floats, speeds: Floats, torques: Floats, innovation: float
) -> None:
    for k in range(speeds.shape[0]):
        turned = speeds[k] != 0
        torques[k] = torques[k] + of_torque[k] * innovation if turned else torques[k]
        speeds[k] = speeds[k] + of_speed[k] * innovation if turned else speeds[k]


@compiled
def _add(of_innovation: Floats, run: Floats, innovation: float) -> None:
    """Correct a run of a ring that has no turn in it: the compiler makes vectors of it."""
    for k in range(run.shape[0]):
        run[k] += of_innovation[k] * innovation
