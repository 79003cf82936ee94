"""What each confirmed answer teaches: of the load law, of the string, of the wall."""

from vsensor.estimator.doubt import doubt_by_noise
from vsensor.estimator.learn import learn, lose_sight
from vsensor.estimator.misfit import MEMORY_S
from vsensor.estimator.responses import ROCK_MEMORY_S, TOLD_BIT_SPEED, TOLD_BIT_TORQUE, TOLD_TOP_SPEED
from vsensor.estimator.ring import mask_of
from vsensor.estimator.score import EXPECTED, NOW, VALUE
from vsensor.estimator.setdown import look_for_rock, wait_for_weight
from vsensor.estimator.state import Model, State
from vsensor.estimator.tare import APART_S, acceleration, weigh_bound, weigh_tare
from vsensor.estimator.tune import INERTIA, OFF, ON, wall_torque
from vsensor.jit import compiled, inlined

TRUSTED = 6.25
"""A prediction that misses by less than so many variances, 2.5 deviations, misses by the rock alone."""
LEAST_SURPRISE = 0.05
"""Innovations so much smaller than expected are none: the string stands still."""
TURNING = 0.5
"""What the wall takes is told while the string turns faster than this, rad/s,"""
STEADY = (0.2, 0.5)
"""and its bit as fast as its top but for such a share, where a tare is taken or friction bounded,"""
STEADY_S = 5.0
"""for so long: all of the wall rubs then, and the string turns as one."""


@inlined
def confirmed_step(model: Model, state: State) -> int:
    """The internal step whose answer no later innovation corrects."""
    return int((state.ticks[0] - model.lag) * model.steps + model.steps - 1)


@compiled
def foretold_for(model: Model, state: State, kind: int) -> tuple[int, int]:
    """The tick whose prediction has just been confirmed, and the internal step that it was for."""
    ahead = model.horizons[kind]
    # Only one step of a tick was foretold from the last step of a tick.
    tick = (confirmed_step(model, state) - ahead + 1) // model.steps - 1
    return tick, tick * model.steps + model.steps - 1 + ahead


@inlined
def study_law(model: Model, state: State) -> None:
    """Learn the load law from what is confirmed of a bit on bottom."""
    tick, step = foretold_for(model, state, NOW)
    at = step & mask_of(state.told.shape[2])
    speed, torque = state.told[0, TOLD_BIT_SPEED, at], state.told[0, TOLD_BIT_TORQUE, at]
    if wait_for_weight(state.learned) and model.learns:
        held = state.held[(state.ticks[0] - model.lag) % state.held.shape[0]]
        learn(state.learned, held, _unmoved(state, tick, speed), torque, model.rate, state.ticks[0])


@inlined
def await_rock(model: Model, state: State) -> None:
    """Look for the rock that a bit told to be on bottom will meet."""
    lose_sight(state.learned)
    _, step = foretold_for(model, state, NOW)
    at = step & mask_of(state.told.shape[2])
    speed, torque = state.told[0, TOLD_BIT_SPEED, at], state.told[0, TOLD_BIT_TORQUE, at]
    look_for_rock(state.learned, speed, torque, -state.off_bottom[0] / model.rate, model.rate)


@inlined
def _unmoved(state: State, tick: int, speed: float) -> float:
    """The speed that the bit would have had but for the rock's own whims, as foretold before they came.

    What slows the bit raises its torque: of pairs moved by the rock the law would look flatter than it is
    (Berkson 1950 has the remedy). Where a prediction misses by more than the rock could, it is not used.
    """
    foretold = state.scores.foretold[NOW, 0, :, tick % state.scores.foretold.shape[3]]
    miss = foretold[VALUE] - speed
    if miss * miss < TRUSTED * foretold[EXPECTED] and foretold[VALUE] * speed > 0:
        return float(foretold[VALUE])
    return speed


@inlined
def study_string(model: Model, state: State) -> None:
    """Add up how well the model foresaw this tick's speed, and its shadows of other delays and impedances."""
    misfit, crossed = state.tuning.misfit, state.tuning.crossed
    surprise = 0.0
    for which in range(misfit.shape[0]):  # the same for all: none has its own misses excused
        surprise += state.surprise[which] / misfit.shape[0]
    by_noise = model.gains.innovation[state.level[0]] * state.noisier[0]
    expected = by_noise * max(LEAST_SURPRISE, surprise)
    keep = 1.0 - 1.0 / (MEMORY_S * model.rate)
    for which in range(misfit.shape[0]):
        misfit[which] = keep * misfit[which] + state.innovation[which] ** 2 / expected
    by_delay = state.innovation[1] - state.innovation[2]
    by_impedance = state.innovation[3] - state.innovation[4]
    crossed[0] = keep * crossed[0] + by_delay * by_impedance / expected


@inlined
def study_wall(model: Model, state: State) -> None:
    """Take a tare of a bit that has long been off bottom: so long as a confirmation takes."""
    lose_sight(state.learned)
    if (state.off_bottom[0] - model.lag) * model.steps >= model.now and _turns_as_one(model, state, OFF):
        inertial, wall, torque, doubt = _left_over(model, state)
        weigh_tare(state.tuning, inertial, wall, torque, doubt, model.rate)


@inlined
def bound_wall(model: Model, state: State) -> None:
    """Bound friction by one that is not told to be: the rock's own torque is what it is uncertain by."""
    if _turns_as_one(model, state, ON):
        inertial, wall, torque, doubt = _left_over(model, state)
        doubt += 2.0 * ROCK_MEMORY_S / APART_S * state.rock_square[0]
        weigh_bound(state.tuning, inertial, wall, torque, doubt, model.rate)


@inlined
def _turns_as_one(model: Model, state: State, which: int) -> bool:
    """Whether the string has done so for long."""
    step = confirmed_step(model, state)
    mask = mask_of(state.told.shape[2])
    speed = state.told[0, TOLD_BIT_SPEED, step & mask]
    top = state.told[0, TOLD_TOP_SPEED, (step - (model.now - model.behind * model.steps)) & mask]
    steady = abs(top) > TURNING and abs(speed - top) < STEADY[which] * abs(top)
    ticks = state.tuning.steady
    ticks[which] = ticks[which] + 1 if steady else 0
    ticks[1 - which] = 0
    return bool(ticks[which] > STEADY_S * model.rate)


@inlined
def _left_over(model: Model, state: State) -> tuple[float, float, float, float]:
    """What inertia and wall take as configured, the bit's torque, N·m, and its variance by noise."""
    step = confirmed_step(model, state)
    mask = mask_of(state.told.shape[2])
    speed, torque = state.told[0, TOLD_BIT_SPEED, step & mask], state.told[0, TOLD_BIT_TORQUE, step & mask]
    travel, step_s = model.now - model.behind * model.steps, 1.0 / (model.rate * model.steps)
    inertia = 0.5 * model.drive_rates[0] * step_s / (1.0 + state.tuning.value[INERTIA])
    inertial = inertia * acceleration(state.told[0, TOLD_TOP_SPEED], step, travel, step_s)
    wall = wall_torque(model.line, state.tuning, speed)
    return inertial, wall, torque, doubt_by_noise(model, state, TOLD_BIT_TORQUE)
