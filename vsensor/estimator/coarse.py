"""A channel that is read in steps coarser than the noise that is told of it.

A speed in whole revolutions a minute is off by up to half of one, and stays so for as long as the reading
does: that is more than its noise, and is not white. How coarse it is the record itself tells: all changes are
multiples of one step, their greatest common divisor (Euclid). Gains depend on the ratio of rock to noise
alone: where both channels are noisier by a factor than they were worked out for, those of a rock that is
calmer by the same factor hold, and all variances are larger by its square.
"""

import math

from vsensor.estimator.state import SPEED, TORQUE, Model, State
from vsensor.jit import compiled

CHANGES = 20
"""After so many changes, by chance they would not all be multiples of one step,"""
BLOCK_S = 2.0
"""and after so long, it is told how coarse a channel is."""
FINE = 0.01
"""What is so small a share of the noise that is told is no step, but rounding."""
SHARES = 1 / math.sqrt(12), 1.0
"""For so much of a step a reading's error counts as noise. Torque moves on by steps from one reading to the
next, so that its error (rms) is another each time. The speed of a stiff drive hardly moves: of twelve errors
that are the same the mean is no better than one: as if there had been one, of twelvefold variance."""

STEP, COUNT, TICKS = range(3)
"""Of the present block of changes: the step of which all are multiples, how many there were, its ticks."""


@compiled
def watch_steps(model: Model, state: State, place: int) -> None:
    """Look at the change that the newest inputs bring, and judge the channels where a block has ended."""
    before = (place - 1) % state.inputs.shape[1]
    ended = False
    for channel in (TORQUE, SPEED):
        block, noise = state.steps[channel], model.noise[channel]
        change = abs(state.inputs[channel, place] - state.inputs[channel, before])
        block[TICKS] += 1.0
        if change > FINE * noise:
            if block[COUNT] == 0.0 or SHARES[channel] * block[STEP] > noise:  # else it is fine enough already
                block[STEP] = _divisor(change, block[STEP], FINE * noise)
            block[COUNT] += 1.0
        if block[COUNT] >= CHANGES and block[TICKS] >= BLOCK_S * model.rate:
            state.resolution[channel] = block[STEP]
            block[:] = 0.0
            ended = True
    if ended:
        torque, speed = coarseness(model, state, TORQUE), coarseness(model, state, SPEED)
        state.coarse[0] = max(1.0, torque * torque, speed * speed)


@compiled
def coarseness(model: Model, state: State, channel: int) -> float:
    """By what a channel is noisier for its steps than was told; less than 1 where they do not matter."""
    return float(SHARES[channel] * state.resolution[channel] / model.noise[channel])


@compiled
def _divisor(one: float, other: float, fine: float) -> float:
    """The greatest number of which both are multiples, but for what is fine."""
    while other > fine:
        rest = one % other
        one, other = other, min(rest, other - rest)
    return one
