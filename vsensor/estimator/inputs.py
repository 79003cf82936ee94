"""What comes in at a tick: samples, what is wrong with them, and whether the bit is off bottom."""

from vsensor.estimator.noise import watch_steps
from vsensor.estimator.readings import watch_readings
from vsensor.estimator.setdown import expect_rock
from vsensor.estimator.slips import watch_slips
from vsensor.estimator.state import FLAGS, Model, State
from vsensor.estimator.tune import OFFSET
from vsensor.jit import inlined
from vsensor.quality import Reason

_WARMING_UP = int(Reason.WARMING_UP)
_STALE_TORQUE = int(Reason.STALE_TORQUE)
_STALE_SPEED = int(Reason.STALE_SPEED)
_TORQUE_TOO_LOW = int(Reason.TORQUE_TOO_LOW)


@inlined
def enter(model: Model, state: State, torque: float, speed: float, flags: int) -> int:
    """Enter a tick's samples; returns its flags, and those of samples not finite or beyond belief."""
    if not abs(torque) <= model.limits[0]:
        flags |= _STALE_TORQUE
    if not abs(speed) <= model.limits[1]:
        flags |= _STALE_SPEED
    offset = state.tuning.value[OFFSET] / model.passed
    _keep(state, 0, torque - offset, flags & _STALE_TORQUE != 0)
    _keep(state, 1, speed, flags & _STALE_SPEED != 0)
    place = state.ticks[0] % state.inputs.shape[1]
    watch_steps(model, state, place)
    watch_readings(model, state, place)
    if state.tuning.too_low[0]:
        flags |= _TORQUE_TOO_LOW
    return flags | watch_slips(model, state, place)


@inlined
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


@inlined
def follow_bit(model: Model, state: State, off: bool) -> None:
    """Count since when the bit has been off bottom; the model's own is a travel time behind."""
    count = state.off_bottom[0]
    state.off_bottom[0] = max(count, 0) + 1 if off else min(count, 0) - 1
    first = state.ticks[0] == 0
    if first or abs(state.off_bottom[0]) * model.steps >= model.now:
        expect_rock(state.learned, off, first)


@inlined
def lasting(model: Model, state: State, flags: int) -> int:
    """Flags of the confirmed answer: all that were raised on any input that takes part in it."""
    tick = state.ticks[0]
    told = _WARMING_UP if tick - state.ticks[1] < model.span else 0
    for bit in range(FLAGS):
        if flags >> bit & 1:
            state.last_seen[bit] = tick
        if tick - state.last_seen[bit] < model.span:
            told |= 1 << bit
    return told
