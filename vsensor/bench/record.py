"""What the benchmarks' sensor hears: the deep well's rig in software, drilling, with real sensors' noise."""

import numpy as np

from vsensor.config import Rig
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import State
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

OF_EACH_STRING = ("motor", "waves", "junctions", "balances", "rock", "told", "innovation", "surprise")
"""What a state has of its strings one by one, the model's own first."""
ROUND_S = 10.0
"""So long is what is sent over and over,"""
BEGUN_S = 30.0
"""after the string has been brought to speed;"""
FADE_S = 5.0
"""and for so long its end fades into its beginning."""


def drilled(rig: Rig, ticks: int) -> tuple[Floats, Floats]:
    """Motor torque and speed of so many ticks, from standstill on; shapes (ticks,)."""
    source = SimulatedRig(rig, PLANS[Scenario.SMOOTH], seed=1)
    readings = [source.sample() for _ in range(ticks)]
    torque, speed = np.array([(reading.motor_torque, reading.motor_speed) for reading in readings]).T
    return np.ascontiguousarray(torque), np.ascontiguousarray(speed)


def endless(rig: Rig) -> tuple[Floats, Floats]:
    """Motor torque and speed of a string that turns, sent over and over: the end runs into the beginning.

    With a seam the speed would leap as inertia lets none, and be refused for as long as `restart_gap` says.
    """
    begun, ticks, fade = (round(seconds * rig.loop.rate) for seconds in (BEGUN_S, ROUND_S, FADE_S))
    torque, speed = (_rounded(of[begun:], ticks, fade) for of in drilled(rig, begun + ticks + fade))
    return torque, speed


def _rounded(record: Floats, ticks: int, fade: int) -> Floats:
    """So many ticks of a longer record, the first of which fade in out of what comes behind the last."""
    once = record[:ticks].copy()
    share = np.arange(fade) / fade
    once[:fade] = share * record[:fade] + (1 - share) * record[ticks:]
    return once


def alone(state: State) -> State:
    """The model string without its shadows, as views."""
    return state._replace(**{name: getattr(state, name)[:1] for name in OF_EACH_STRING})
