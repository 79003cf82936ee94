"""The bit of one delay ago: by measurement where both channels speak, by the load law where one is silent.

Both walk the same array of waves, so the one takes over from the other where it stands. With both
channels the wave down is known at the top and the string is peeled. With one, the march under the
load law tells the wave up, and the channel that is left gives the wave down:

    speed known      f = g + 2ζω
    torque known     J dω/dt = T_motor − T_string, T_string = g + ζω, and then the same
"""

from vsensor.estimator.learn import load_in_force
from vsensor.estimator.line import REST_SPEED, descend, march, turn_top
from vsensor.estimator.load import foot, turning
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import BIT, TOP, Model, State
from vsensor.estimator.top_drive import string_speed, string_torque, turning_torque
from vsensor.jit import compiled
from vsensor.quality import Reason

EVERY_JUNCTION = 1 << 60
"""A reach for the march that spares no junction."""

_STALE_TORQUE = Reason.STALE_TORQUE.bit_length() - 1
_STALE_SPEED = Reason.STALE_SPEED.bit_length() - 1


@compiled
def confirm(model: Model, state: State) -> None:
    """Run the internal steps of this tick, whose input and flags have been entered."""
    tick = state.ticks[0]
    width = state.torque.shape[0] // 2
    oldest = (tick + 1) % width
    torque = state.torque[oldest : oldest + width]
    speed = state.speed[oldest : oldest + width]
    # A channel counts as silent for as long as the smoother's window holds a value that was held.
    no_torque = tick - state.last_seen[_STALE_TORQUE] < width
    no_speed = tick - state.last_seen[_STALE_SPEED] < width
    for row in range(model.steps):
        step = tick * model.steps + row
        if no_speed:
            _by_torque(model, state, step, string_torque(model.smooth, row, torque))
        elif no_torque:
            _by_speed(model, state, step, string_speed(model.smooth, row, speed))
        else:
            _by_both(model, state, step, row, torque, speed)


@compiled
def _by_both(model: Model, state: State, step: int, row: int, torque: Floats, speed: Floats) -> None:
    mask = state.waves.shape[1] - 1
    accelerates = turning_torque(model.smooth, row, speed)
    t = string_torque(model.smooth, row, torque) - accelerates
    w = string_speed(model.smooth, row, speed)
    t, w = descend(model.line, state.waves, state.junctions, step, t, w)
    before = state.confirmed[0, (step - 1) & mask]
    state.confirmed[0, step & mask] = w
    state.confirmed[1, step & mask] = t - 0.5 * model.bit_rate * (w - before)
    if row == model.steps - 1:
        _settle(model, state, step, accelerates)


@compiled
def _settle(model: Model, state: State, step: int, accelerates: float) -> None:
    """Make of what was measured a state that a march can set out from."""
    for junction in range(state.junctions.shape[0]):
        if abs(state.junctions[junction]) < REST_SPEED:
            state.junctions[junction] = 0.0
    last = model.line.impedance.shape[0] - 1
    f = state.waves[last, (step - model.line.round_trip[last]) & (state.waves.shape[1] - 1)]
    state.balances[TOP] = accelerates
    load = load_in_force(state.learned, model.bit_rate)
    state.balances[BIT] = turning(load, foot(model.line), f, state.junctions[last + 1])


@compiled
def _by_torque(model: Model, state: State, step: int, torque: float) -> None:
    g = _march_up(model, state, step)
    w, state.balances[TOP] = turn_top(
        model.line, model.drive_rate, torque - g, state.junctions[0], state.balances[TOP]
    )
    _send_down(model, state, step, g, w)


@compiled
def _by_speed(model: Model, state: State, step: int, speed: float) -> None:
    g = _march_up(model, state, step)
    state.balances[TOP] = 0.5 * model.drive_rate * (speed - state.junctions[0])
    _send_down(model, state, step, g, speed)


@compiled
def _march_up(model: Model, state: State, step: int) -> float:
    """One step of the string under the load law; returns the wave g at its top."""
    mask = state.waves.shape[1] - 1
    g, state.balances[BIT] = march(
        model.line,
        load_in_force(state.learned, model.bit_rate),
        state.waves,
        step - 1,
        1,
        EVERY_JUNCTION,
        0.0,
        state.junctions,
        state.balances[BIT],
        state.told,
    )
    state.confirmed[0, step & mask] = state.told[0, 0]
    state.confirmed[1, step & mask] = state.told[1, 0]
    return g


@compiled
def _send_down(model: Model, state: State, step: int, g: float, speed: float) -> None:
    state.junctions[0] = speed
    state.waves[0, step & (state.waves.shape[1] - 1)] = g + 2 * model.line.impedance[0] * speed
