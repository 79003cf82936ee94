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
from vsensor.estimator.line import rubbing, turn_top
from vsensor.estimator.load import law
from vsensor.estimator.noise import judge_noise
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
from vsensor.estimator.ring import mask_of, room_of
from vsensor.estimator.rise import rise
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.estimator.slips import REST_SPEED
from vsensor.estimator.state import BIT, SPEED, TOP, TORQUE, Model, State, Strand, line_of, strand
from vsensor.jit import compiled, inlined

WILD = 5.0
"""An innovation beyond so many deviations counts as one of so many (Huber 1964)."""
SURPRISE_S = 2.0
"""Time over which the innovations' size is judged."""


@inlined
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


@inlined
def observe(model: Model, state: State) -> None:
    """Run all strings by the internal steps of this tick, whose input has been entered, and correct them.

    The waves that come back are kept for the model string alone, and so is what corrects them (along.py):
    nobody looks along a shadow.
    """
    load = load_in_force(state.learned, model.bit_rate)
    place = (state.ticks[0] - model.behind) % state.inputs.shape[1]
    silent = _torque_silent(model, state, place)
    for row in range(model.steps):
        step = state.ticks[0] * model.steps + row
        for which in range(state.rock.shape[0]):
            state.rock[which] *= model.fade
        rise(model, load, state, step)
        _turn_tops(model, state, place, silent, step, (row + 1) / model.steps)
        keep_returned(model.line, state.waves[0], state.junctions[0], step, state.returned)
    heard = not silent and state.missing[SPEED, place] == 0
    speed = state.inputs[SPEED, place] / model.turns
    for which in range(state.waves.shape[0]):
        off = speed - state.junctions[which, 0]
        state.innovation[which] = _tamed(model, state, which, off) if heard else math.nan
    if heard:
        _correct(model, state, place)
    past = state.ticks[0] % state.innovations.shape[0]
    state.innovations[past] = state.innovation[0] if heard else 0.0
    state.levels[past] = state.level[0]
    judge_noise(model, state, past)


@inlined
def _turn_tops(model: Model, state: State, place: int, silent: bool, step: int, share: float) -> None:
    """Turn all tops by what was measured when such a share of this tick was over."""
    before = (place - 1) % state.inputs.shape[1]
    earlier, later = state.inputs[SPEED, before], state.inputs[SPEED, place]
    for which in range(state.waves.shape[0]):
        line, string = line_of(model, which), strand(state, which)
        if silent:
            speed = earlier + share * (later - earlier)
            turn_by_speed(line, model.drive_rates[which], string, step, speed / model.turns)
        else:
            torque = _torque_at(model, state, which, place, share)
            turn_by_torque(line, model.drive_rates[which], string, step, torque * model.passed)


@inlined
def _torque_silent(model: Model, state: State, place: int) -> bool:
    """Whether a torque sample is missing that this tick's steps, those of the sample at `place`, need."""
    width, whole = state.inputs.shape[1], int(model.late)
    early, then = (place + whole - 1) % width, (place + whole) % width
    after = (place + min(whole + 1, model.behind)) % width
    return bool(state.missing[TORQUE, early] + state.missing[TORQUE, then] + state.missing[TORQUE, after] > 0)


@inlined
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


@inlined
def _correct(model: Model, state: State, place: int) -> None:
    """Correct all of the strings, and what is held against the torques that are still to act."""
    gains, level = model.gains, state.level[0]
    last = state.ticks[0] * model.steps + model.steps - 1
    for which in range(state.waves.shape[0]):
        innovation = state.innovation[which]
        correct_ends(gains, level, strand(state, which), innovation)
        for ahead in range(model.behind + 1):
            at = (place + ahead) % state.motor.shape[1]
            state.motor[which, at] += gains.motor[level, ahead] * innovation / model.passed
    correct_told(gains.told[level], state.told, last, state.innovation)
    correct_waves(gains.waves[level], model.inside, state.waves, last, state.innovation)


@inlined
def turn_by_torque(line: Line, drive_rate: float, string: Strand, step: int, torque: float) -> None:
    """End an internal step of a string in which g has risen, and whose top drive passes on `torque`."""
    g = string.waves[0, step & mask_of(string.waves.shape[1])]
    w, string.balances[TOP] = turn_top(
        line, drive_rate, torque - g, string.junctions[0], string.balances[TOP]
    )
    _send_down(line, string, step, g, w)


@inlined
def turn_by_speed(line: Line, drive_rate: float, string: Strand, step: int, speed: float) -> None:
    """The same of a string whose top turns at `speed`, whatever torque that takes."""
    g = string.waves[0, step & mask_of(string.waves.shape[1])]
    string.balances[TOP] = 0.5 * drive_rate * (speed - string.junctions[0])
    _send_down(line, string, step, g, speed)


@inlined
def _send_down(line: Line, string: Strand, step: int, g: float, speed: float) -> None:
    z = line.impedance[0]
    now = step & mask_of(string.told.shape[1])
    string.junctions[0] = speed
    string.waves[0, now] = g + 2 * z * speed
    string.told[TOLD_TOP_SPEED, now] = speed
    string.told[TOLD_TOP_TORQUE, now] = g + z * speed + rubbing(line, 0, speed)


@inlined
def note_rest(model: Model, state: State) -> None:
    """Note how much of the torque resting parts of the wall may hold at this tick."""
    held = 0.0
    for junction in range(state.junctions.shape[1]):
        if state.junctions[0, junction] == 0:
            held += model.line.static[junction]
    state.held[state.ticks[0] % state.held.shape[0]] = held


@inlined
def _tamed(model: Model, state: State, which: int, innovation: float) -> float:
    """An innovation held within what can be believed; keeps count of how large they are."""
    expected = model.gains.innovation[state.level[0]] * state.noisier[0]
    limit = WILD * math.sqrt(expected * max(1.0, state.surprise[which]))
    tamed = min(max(innovation, -limit), limit)
    state.surprise[which] += (tamed * tamed / expected - state.surprise[which]) / (SURPRISE_S * model.rate)
    return tamed


@inlined
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


@inlined
def correct_told(of_innovation: Floats, told: Floats, last: int, innovation: Floats) -> None:
    """Correct the answers (N, 4, size) of the steps up to `last` by gains (4, L), each by its innovation.

    A bit that rested rested. Nobody asks what the top of a shadow did.
    """
    lag, size = of_innovation.shape[1], room_of(told.shape[2])
    done = 0
    while done < lag:
        at = (last + 1 - lag + done) & (size - 1)
        until = done + min(lag - done, size - at)
        end = at + until - done
        of_speed, of_torque = (
            of_innovation[TOLD_BIT_SPEED, done:until],
            of_innovation[TOLD_BIT_TORQUE, done:until],
        )
        for which in range(told.shape[0]):
            speeds, torques = told[which, TOLD_BIT_SPEED, at:end], told[which, TOLD_BIT_TORQUE, at:end]
            _correct_bit(of_speed, of_torque, speeds, torques, innovation[which])
        for of_top in (TOLD_TOP_SPEED, TOLD_TOP_TORQUE):
            _add(of_innovation[of_top, done:until], told[0, of_top, at:end], innovation[0])
        done = until


@compiled
def correct_waves(
    of_innovation: Floats, inside: Integers, waves: Floats, last: int, innovation: Floats
) -> None:
    """Correct waves (N, M, size) of the `inside` (M,) steps up to `last`, each string by its innovation.

    The gains (M, L) are those of an innovation of 1 rad/s, newest last.
    """
    lag, size = of_innovation.shape[1], room_of(waves.shape[2])
    for i in range(waves.shape[1]):
        done = lag - min(inside[i], lag)
        while done < lag:
            at = (last + 1 - lag + done) & (size - 1)
            until = done + min(lag - done, size - at)
            gains = of_innovation[i, done:until]
            for which in range(waves.shape[0]):
                _add(gains, waves[which, i, at : at + until - done], innovation[which])
            done = until


@inlined
def _correct_bit(
    of_speed: Floats, of_torque: Floats, speeds: Floats, torques: Floats, innovation: float
) -> None:
    for k in range(speeds.shape[0]):
        turned = speeds[k] != 0
        torques[k] = torques[k] + of_torque[k] * innovation if turned else torques[k]
        speeds[k] = speeds[k] + of_speed[k] * innovation if turned else speeds[k]


@inlined
def _add(of_innovation: Floats, run: Floats, innovation: float) -> None:
    """Correct a run of a ring that has no turn in it: the compiler makes vectors of it."""
    for k in range(run.shape[0]):
        run[k] += of_innovation[k] * innovation
