"""What a confirmed answer may be wrong by: by noise and rock, by parameters, by when the bit broke loose."""

from vsensor.estimator.responses import TOLD_BIT_TORQUE, TOLD_TOP_SPEED
from vsensor.estimator.ring import mask_of
from vsensor.estimator.state import Model, State
from vsensor.estimator.tune import DELAY, FRICTION, LATER, OFFSET, SHADOWED, SOONER, wall_torque
from vsensor.jit import inlined


@inlined
def doubt(model: Model, state: State, quantity: int, step: int) -> float:
    """Variance of a confirmed answer, that of internal step `step`."""
    variance = doubt_by_noise(model, state, quantity) + _by_shadows(model, state, quantity, step)
    if quantity == TOLD_BIT_TORQUE:
        variance += _by_wall(model, state, step)
    return float(variance)


@inlined
def doubt_by_noise(model: Model, state: State, quantity: int) -> float:
    """Variance of a confirmed answer by noise and rock, as far as innovations are no larger than foreseen."""
    told = model.gains.variance[state.level[0], quantity]
    return float(told * state.noisier[0] * max(1.0, state.surprise[0]))


@inlined
def _by_shadows(model: Model, state: State, quantity: int, step: int) -> float:
    """That by uncertain parameters, by half of what a pair of shadows differs by for so much of one;

    and by when the bit broke loose and how its string rings since, by what the two of that differ from the
    model string: both are as likely as it, and once they are out of step with it they may be so alike.
    """
    told, mask = state.told, mask_of(state.told.shape[2])
    variance = 0.0
    for p in range(SHADOWED):
        later = model.shift if p == DELAY else 0  # with longer delays the bit of a moment is seen later
        more, less = (
            told[1 + 2 * p, quantity, (step + later) & mask],
            told[2 + 2 * p, quantity, (step - later) & mask],
        )
        variance += state.tuning.variance[p] * ((more - less) / (2.0 * model.off[p])) ** 2
    for which in (LATER, SOONER):
        variance += 0.5 * (told[which, quantity, step & mask] - told[0, quantity, step & mask]) ** 2
    return float(variance)


@inlined
def _by_wall(model: Model, state: State, step: int) -> float:
    """That of the bit's torque by uncertain friction and offset, and by what a wall at rest holds."""
    unsure = state.tuning.variance
    # The wall's own speed is the top's at least on average: it rubs where the bit rests.
    top = step - (model.now - model.behind * model.steps)
    speed = state.told[0, TOLD_TOP_SPEED, top & mask_of(state.told.shape[2])]
    wall = wall_torque(model.line, state.tuning, speed)
    by_parameters = (unsure[FRICTION] * wall + 2.0 * state.tuning.shared[0]) * wall + unsure[OFFSET]
    # Parts of the wall that rest hold anything up to their static friction: all of it is equally likely.
    held = state.held[(state.ticks[0] - model.lag) % state.held.shape[0]]
    return float(by_parameters + held * held / 3.0)
