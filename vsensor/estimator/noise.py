"""Channels that are noisier than was told, as the record itself tells.

What is white in the innovations is noise of the speed: what rock or an error of the model does to it goes by
way of the string and of the top drive's inertia, and is smooth from one tick to the next. So the mean square
of the innovations' second differences, against what the gains expect, tells how much larger the noise is.
(Von Neumann 1941 has the same of first differences, to tell noise from a drift.)

A reading in steps is another matter. A speed in whole revolutions a minute is off by up to half of one, and
stays so for as long as the reading does: that is more than its noise, and is not white. How coarse it is its
changes tell: all are multiples of one step, their greatest common divisor (Euclid).

A speed that is read less often than there are ticks is noisier for that as well (readings.py).

Gains depend on the ratio of rock to noise alone: where both channels are noisier by a factor than the gains
were worked out for, those of a rock that is calmer by the same factor hold, and all variances are larger by
its square.
"""

import math

from vsensor.estimator.rock import choose_level
from vsensor.estimator.state import SPEED, TORQUE, Model, State
from vsensor.jit import inlined

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
MEMORY_S = 10.0
"""Time over which innovations tell of noise: at 100 Hz to 5 %."""
SURELY = 1.5
"""Noise is larger than told where its variance surely is: of 61 simulated records, told the noise that they
were made with, none came beyond 1.4 in any 10 s, and of those without wild samples to 1.2."""
NO_MORE = 1.25
"""It is as told again below this."""

STEP, COUNT, TICKS = range(3)
"""Of the present block of changes: the step of which all are multiples, how many there were, its ticks."""


@inlined
def watch_steps(model: Model, state: State, place: int) -> None:
    """Look at the change that the newest inputs bring, and judge the channels where a block has ended."""
    before = (place - 1) % state.inputs.shape[1]
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


@inlined
def judge_noise(model: Model, state: State, past: int) -> None:
    """Judge by the innovation at `past` in their ring, by steps and lines, how much noisier channels are."""
    size = state.innovations.shape[0]
    one, other, third = (
        state.innovations[past],
        state.innovations[(past - 1) % size],
        state.innovations[(past - 2) % size],
    )
    if one != 0 and other != 0 and third != 0:  # 0 is none
        apart = one - 2.0 * other + third
        square = apart * apart / (6.0 * model.gains.innovation[state.level[0]])
        state.white[0] += (square - state.white[0]) / (MEMORY_S * model.rate)
    torque, speed = _coarseness(model, state, TORQUE), _coarseness(model, state, SPEED)
    least = SURELY if state.noisier[0] == 1.0 else NO_MORE
    white = state.white[0] if state.white[0] > least else 1.0
    noisier = max(white, torque * torque, speed * speed, state.lasts[0])
    if noisier != state.noisier[0]:
        state.noisier[0] = noisier
        choose_level(model, state)


@inlined
def _coarseness(model: Model, state: State, channel: int) -> float:
    """By what a channel is noisier for its steps than was told; less than 1 where they do not matter."""
    return float(SHARES[channel] * state.resolution[channel] / model.noise[channel])


@inlined
def _divisor(one: float, other: float, fine: float) -> float:
    """The greatest number of which both are multiples, but for what is fine."""
    while other > fine:
        rest = one % other
        one, other = other, min(rest, other - rest)
    return one
