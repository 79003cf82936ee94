"""A speed that is read less often than there are ticks, or was made so by a resampling.

Between two readings lies a straight line, which is as wrong as they are, for as long as it lasts. One reading
stands for n ticks, and its noise for that of n readings, which is n times larger in all that is slow. That
noise is not white: innovations do not tell it. But a line's second differences are nothing but rounding, and
they tell how many readings there were. A torque that is read so costs little, for the top drive's inertia
takes most of its noise away; to doubt the speed with it would cost more.
"""

from vsensor.estimator.state import SPEED, Model, State
from vsensor.jit import inlined

STRAIGHT = 1e-12
"""Of a speed so small a part is rounding."""
LINES = 0.3
"""Where so many ticks lie on lines between their neighbours, speed is read less often than there are ticks:
where it is read at every other one, half of them, or at every third, but not at a tick's time, a third."""
ENOUGH, ENOUGH_S = 5, 0.5
"""So many bends, and so long, are enough: no line is so straight by chance."""
MOVED, BENT, BENDS, LATELY = range(4)
"""Of the present block of speeds: the ticks, those at which they leave a straight line, how often that begins
anew, and whether the newest one does."""


@inlined
def watch_readings(model: Model, state: State, place: int) -> None:
    """Look whether the newest speed leaves a straight line, and judge where a block has ended."""
    width, speeds = state.inputs.shape[1], state.inputs[SPEED]
    before, first = (place - 1) % width, (place - 2) % width
    if state.ticks[0] < 2 or state.missing[SPEED, place] + state.missing[SPEED, before] > 0:
        return
    if speeds[place] == speeds[before]:  # what stands still tells nothing
        return
    off_line = abs(speeds[place] - 2.0 * speeds[before] + speeds[first])
    _note(model, state, off_line > STRAIGHT * abs(speeds[before]))


@inlined
def _note(model: Model, state: State, bends: bool) -> None:
    block = state.bends
    bent, block[LATELY] = block[LATELY] > 0.0, 1.0 if bends else 0.0
    block[MOVED] += 1.0
    if bends:
        block[BENT] += 1.0
        block[BENDS] += 0.0 if bent else 1.0
    on_lines = block[MOVED] - block[BENT] >= LINES * block[MOVED]
    whole = bent and not bends  # of even readings no part is left over from one block to the next
    if block[BENT] >= ENOUGH and block[MOVED] >= ENOUGH_S * model.rate and (whole or not on_lines):
        # A reading at a tick's time bends the line once, one between two ticks at both.
        readings = max(block[BENDS], 0.5 * block[BENT])
        state.lasts[0] = block[MOVED] / readings if on_lines else 1.0
        block[:LATELY] = 0.0
