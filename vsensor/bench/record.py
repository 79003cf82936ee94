"""What the benchmarks' sensor hears: the deep well's rig in software, drilling, with real sensors' noise."""

import numpy as np

from vsensor.config import Rig
from vsensor.estimator.sections import Floats
from vsensor.estimator.state import State
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

OF_EACH_STRING = ("motor", "waves", "junctions", "balances", "rock", "told", "innovation", "surprise")
"""What a state has of its strings one by one, the model's own first."""


def drilled(rig: Rig, ticks: int) -> tuple[Floats, Floats]:
    """Motor torque and speed of so many ticks, from standstill on; shapes (ticks,)."""
    source = SimulatedRig(rig, PLANS[Scenario.SMOOTH], seed=1)
    readings = [source.sample() for _ in range(ticks)]
    torque, speed = np.array([(reading.motor_torque, reading.motor_speed) for reading in readings]).T
    return np.ascontiguousarray(torque), np.ascontiguousarray(speed)


def alone(state: State) -> State:
    """The model string without its shadows, as views."""
    return state._replace(**{name: getattr(state, name)[:1] for name in OF_EACH_STRING})
