"""The bit of one delay ago: by measurement where both channels speak, by the load law where one is silent.

Both walk the same array of waves, so the one takes over from the other where it stands. With both
channels the wave down is known at the top and the string is peeled. With one, the march under the
load law tells the wave up, and the channel that is left gives the wave down:

    speed known      f = g + 2ζω
    torque known     J dω/dt = T_motor − T_string, T_string = g + ζω, and then the same
"""

from vsensor.estimator.along import keep_returned
from vsensor.estimator.learn import load_in_force
from vsensor.estimator.line import REST_SPEED, descend, march, turn_top
from vsensor.estimator.load import foot, turning
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import BIT, TOP, Model, State
from vsensor.estimator.top_drive import speed_alone, string_speed, string_torque, turning_torque
from vsensor.jit import compiled
from vsensor.quality import Reason

EVERY_JUNCTION = 1 << 60
"""A reach for the march that spares no junction."""

STALE_TORQUE = Reason.STALE_TORQUE.bit_length() - 1
STALE_SPEED = Reason.STALE_SPEED.bit_length() - 1


@compiled
def silent(state: State, channel: int) -> bool:
    """Whether the window still holds a value that was held because its channel was silent."""
    return bool(state.ticks[0] - state.last_seen[channel] < state.torque.shape[0] // 2)


@compiled
def window(state: State, channel: Floats) -> Floats:
    """The samples that the smoother sees at this tick, newest last."""
    width = channel.shape[0] // 2
    oldest = (state.ticks[0] + 1) % width
    return channel[oldest : oldest + width]


@compiled
def confirm(model: Model, state: State) -> None:
    """Run the internal steps of this tick, whose input and flags have been entered."""
    torque = window(state, state.torque)
    speed = window(state, state.speed)
    for row in range(model.steps):
        step = state.ticks[0] * model.steps + row
        if silent(state, STALE_SPEED):
            _by_torque(model, state, step, string_torque(model.smooth.confirmed, row, torque))
        elif silent(state, STALE_TORQUE):
            _by_speed(model, state, step, speed_alone(model.smooth.confirmed, row, speed))
        else:
            _by_both(model, state, step, row, torque, speed)


@compiled
def _by_both(model: Model, state: State, step: int, row: int, torque: Floats, speed: Floats) -> None:
    mask = state.waves.shape[1] - 1
    smooth = model.smooth.confirmed
    accelerates = turning_torque(smooth, row, speed)
    t = string_torque(smooth, row, torque) - accelerates
    w = string_speed(smooth, row, torque, speed)
    state.top[0], state.top[1] = t, w
    t, w = descend(model.line, state.waves, state.returned, state.junctions, step, t, w)
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
        step - 1,
        EVERY_JUNCTION,
        0.0,
        state.junctions,
        state.balances[BIT],
        state.told,
    )
    keep_returned(model.line, state.waves, state.junctions, step, state.returned)
    state.confirmed[0, step & mask] = state.told[0, 0]
    state.confirmed[1, step & mask] = state.told[1, 0]
    return g


@compiled
def _send_down(model: Model, state: State, step: int, g: float, speed: float) -> None:
    state.junctions[0] = speed
    state.waves[0, step & (state.waves.shape[1] - 1)] = g + 2 * model.line.impedance[0] * speed
