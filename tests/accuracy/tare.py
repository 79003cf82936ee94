"""A tare before the record: the same string, turned off bottom by the simulated rig."""

import numpy as np

from tests.cases import Learned
from vsensor.config import Rig
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import OFF_BOTTOM
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import Plan

FOR_S = 60.0
"""About what a driller rotates off bottom after a connection."""
TURNED = Plan(speed=((0, 0), (6, 6), (30, 6), (34, 12)), load=((0, 0),), damping=4.0, rock_noise=0.0)
"""Up to 57 rpm, and from there to 115 rpm: what speeds up tells of its inertia."""
SEED = 7


def off_bottom_first(configured: Rig, true: Rig) -> Learned:
    """What a sensor `configured` in some way learns of a string that is truly another, turned off bottom."""
    simulated = SimulatedRig(true, TURNED, SEED)
    readings = [simulated.sample() for _ in range(round(FOR_S * true.loop.rate))]
    estimator = Estimator(configured)
    estimator.run(
        [reading.motor_torque for reading in readings],
        [reading.motor_speed for reading in readings],
        np.full(len(readings), OFF_BOTTOM, np.uint32),
    )
    return estimator.learned()
