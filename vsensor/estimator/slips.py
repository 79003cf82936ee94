"""A string that hangs in slips: its top stands, and what it is twisted by is no torque of the motor's.

A drive that holds the string tells of its torque. Slips hold it and tell nothing: the driller lets the torque
off, and the top stands though the string, as it was, would turn it back. That is what tells the two apart.
"""

from vsensor.estimator.state import SPEED, TORQUE, Model, State
from vsensor.jit import inlined
from vsensor.quality import Reason

REST_SPEED = 0.2
"""A string whose top turns more slowly than this, rad/s, is taken to stand still."""
STANDS_S = 0.5
"""For so long at the least: it may pass through rest."""
CARRIED_S = 2.0
"""What the string carries is the most that it has carried of late."""
LET_OFF = 0.5
"""Torque is let off where so small a share of that is left,"""
IMPOSSIBLE = 2.0
"""and the string would not stand of itself: innovations squared are so many times what is expected."""
CARRIED, STOOD, IN_SLIPS = range(3)

_IN_SLIPS = int(Reason.IN_SLIPS)


@inlined
def watch_slips(model: Model, state: State, place: int) -> int:
    """Look at a tick's samples, in their places; returns the flag of a string in slips, or none."""
    slips = state.slips
    if state.missing[TORQUE, place] + state.missing[SPEED, place] == 0:
        torque = abs(state.inputs[TORQUE, place]) * model.passed
        stands = abs(state.inputs[SPEED, place]) < REST_SPEED * model.turns
        slips[STOOD] = slips[STOOD] + 1.0 if stands else 0.0
        if not stands:
            slips[IN_SLIPS] = 0.0
        if slips[IN_SLIPS] == 0:
            slips[CARRIED] = max(torque, slips[CARRIED] * (1.0 - 1.0 / (CARRIED_S * model.rate)))
            impossible = torque < LET_OFF * slips[CARRIED] and state.surprise[0] > IMPOSSIBLE
            if impossible and slips[STOOD] > STANDS_S * model.rate:
                slips[IN_SLIPS] = 1.0
    return _IN_SLIPS if slips[IN_SLIPS] > 0 else 0


@inlined
def held_by_slips(state: State) -> float:
    """Variance of a torque that slips may hold: anything up to what the string has carried, either way."""
    return float(state.slips[CARRIED] ** 2 / 3.0)
