"""What is in the lines, told anew as a corrected configuration has it: nothing is stirred by a correction."""

import numpy as np

from vsensor.estimator.responses import TOLD_BIT_TORQUE, TOLD_TOP_TORQUE
from vsensor.estimator.score import VALUE
from vsensor.estimator.sections import Floats, Line
from vsensor.estimator.state import TORQUE, Model, State


def refit_torque(model: Model, state: State, by: float) -> None:
    """Take an offset (N·m at the string) off all torques of before, as off those that are to come.

    A torque that is the same all along the string goes with any motion of it.
    """
    _take_off(state, np.full(len(model.line.viscous), by))
    state.inputs[TORQUE] -= by / model.passed
    state.told[:, TOLD_TOP_TORQUE] -= by
    state.scores.foretold[:, TOLD_BIT_TORQUE, VALUE] -= by


def refit_wall(model: Model, state: State, before: Line) -> None:
    """Give the bit what another friction than that of `before` takes less of the torque, and all on the way.

    Where all of the wall turns one way friction opposes it all along, and any motion stays one of the string.
    Where a part of it rests nobody knows what that holds: there the waves come to fit by themselves.
    """
    speeds = state.junctions[0]
    top = speeds[0]
    if (speeds * top > 0).all():
        _take_off(state, np.cumsum(_rubbing(model.line, top) - _rubbing(before, top)))


def _rubbing(line: Line, speed: float) -> Floats:
    """Friction of each junction of a string that turns, N·m, shape (M + 1,)."""
    return np.asarray(line.viscous * speed + line.kinetic * np.sign(speed))


def _take_off(state: State, by: Floats) -> None:
    """Of the torque in each section, and of the bit's: (M + 1,)."""
    for torques in (state.waves, state.returned):
        torques -= by[:-1, None]
    state.rock[:] -= by[-1]
    state.told[:, TOLD_BIT_TORQUE] -= by[-1]
