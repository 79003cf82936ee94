"""What follows the confirmed bit: waves that have left the surface since, and the march on them.

The smoother waits `lag` ticks before an answer is good enough to be confirmed. What it can say of the
time since is noisier towards the newest sample, but the waves are on their way all the same, and
in a prediction a noisy wave is better than none: they are sent down provisionally, each tick anew.
"""

from vsensor.estimator.confirm import STALE_SPEED, STALE_TORQUE, silent, window
from vsensor.estimator.learn import load_in_force
from vsensor.estimator.line import march, rubbing
from vsensor.estimator.state import BIT, Model, State
from vsensor.estimator.top_drive import string_speed, string_torque, turning_torque
from vsensor.jit import compiled


@compiled
def predict(model: Model, state: State) -> None:
    """March the waves in the string on to now and to the forecast."""
    known = state.ticks[0] * model.steps + model.steps - 1
    heard = known
    if not silent(state, STALE_SPEED) and not silent(state, STALE_TORQUE):
        heard = _send_provisionally(model, state, known)
    state.marching[:] = state.junctions
    march(
        model.line,
        load_in_force(state.learned, model.bit_rate),
        state.waves,
        known,
        model.forecast,
        heard,
        model.forecast,
        0.0,
        state.marching,
        state.balances[BIT],
        state.told,
    )
    place = state.ticks[0] % state.foretold.shape[2]
    for q in range(2):
        state.foretold[0, q, place] = state.told[q, model.now - 1]
        state.foretold[1, q, place] = state.told[q, model.forecast - 1]


@compiled
def _send_provisionally(model: Model, state: State, known: int) -> int:
    """Enter the top section's f from step `known` up to the newest sample; returns the last step entered."""
    smooth = model.smooth.provisional
    torque = window(state, state.torque)
    speed = window(state, state.speed)
    mask = state.waves.shape[1] - 1
    z = model.line.impedance[0]
    between = model.smooth.stride * model.steps
    before_t, before_w = state.top[0], state.top[1]
    step = known
    for row in range(smooth.speed_of_speed.shape[0]):
        t = string_torque(smooth, row, torque) - turning_torque(smooth, row, speed)
        w = string_speed(smooth, row, torque, speed)
        for k in range(between):
            share = (k + 1) / between
            w_here = before_w + share * (w - before_w)
            t_here = before_t + share * (t - before_t) - rubbing(model.line, 0, w_here)
            step += 1
            state.waves[0, step & mask] = t_here + z * w_here
        before_t, before_w = t, w
    return step
