"""The textbook's peeling: torque and speed at the string's top tell of its bottom, without any bit model.

Both are known at the top, so both waves there are. Section by section the wave that went down a round
trip ago meets the one that comes back now. It is exact for any load and any drive, and so an independent
truth for the march and for what is told along the string; noise it only amplifies.
"""

import numpy as np

from vsensor.estimator.line import rubbing
from vsensor.estimator.ring import length_of, mask_of
from vsensor.estimator.sections import Floats, Line
from vsensor.jit import compiled


@compiled
def descend(
    line: Line, waves: Floats, returned: Floats, speeds: Floats, step: int, torque: float, speed: float
) -> tuple[float, float]:
    """Torque and speed at the top at `step`, to those at the bottom, a travel time earlier.

    Enters f and g at the sections' tops at this step into `waves` and `returned` (M, size), and the
    junctions' speeds into `speeds` (M + 1,).
    """
    mask = mask_of(waves.shape[1])
    t, w = torque - rubbing(line, 0, speed), speed
    speeds[0] = speed
    for i in range(line.impedance.shape[0]):
        z = line.impedance[i]
        waves[i, step & mask] = t + z * w
        g = t - z * w
        returned[i, step & mask] = g
        arrived = waves[i, (step - line.round_trip[i]) & mask]
        t, w = 0.5 * (arrived + g), 0.5 * (arrived - g) / z
        t -= rubbing(line, i + 1, w)
        speeds[i + 1] = w
    return t, w


def peeled(line: Line, torques: Floats, speeds: Floats) -> Floats:
    """Torque and speed at the bottom of a string without waves at first, shape (n, 2)."""
    waves = np.zeros((len(line.impedance), length_of(line.round_trip.max())))
    returned, junctions = np.zeros_like(waves), np.zeros(len(line.impedance) + 1)
    steps = enumerate(zip(torques, speeds, strict=True))
    bottom = [descend(line, waves, returned, junctions, k, float(t), float(w)) for k, (t, w) in steps]
    return np.array(bottom, dtype=np.float64)
