"""The same shaft and load stepped finely, by the kernels that the program itself runs.

`ForwardLine` takes the torque it is given as going in straight lines from step to step, as its
trapezoid rule for the load does. A torque that is 0 before its first step and T₀ at it has therefore
risen half a step earlier. So the k-th answer stands for the time (k + ½) h, and with that said the
error falls with h² (away from the fronts, which no grid can follow).
"""

import numpy as np

from vsensor.config import Bit, Component, TopDrive
from vsensor.estimator import component
from vsensor.estimator.forward import ForwardLine
from vsensor.estimator.sections import cut
from vsensor.paper.shaft import Floats, Load, Response, Trace

THIRDS = 3
"""By how much the finer of two grids is finer: with 3, every half-step time of the coarser is in both."""


def stepped(shaft: Component, load: Load, torque: float, until: float, steps: int) -> Response:
    """From rest, a torque (N·m) stepped on at time 0, to `until` (s), in `steps` steps a one-way delay.

    All three traces share one time grid, the halves of the steps.
    """
    h = component.delay(shaft) / steps
    count = int(until / h)
    line = cut((shaft,), h, shaft.length)
    bit = Bit(inertia=load.inertia, viscous_friction=load.damping)
    ran = count + steps  # the end is answered one delay late
    top, end, _ = ForwardLine(line, TopDrive(), bit, h).run(np.full(ran, torque), np.zeros(ran))
    top, end = top[:count], end[steps:]
    zeta = component.impedance(shaft)
    arriving = np.zeros(count)
    arriving[steps:] = (torque + zeta * top)[: max(0, count - steps)]
    time: Floats = (np.arange(count, dtype=np.float64) + 0.5) * h
    return Response(Trace(time, top), Trace(time, end), Trace(time, arriving - zeta * end))


def refined(shaft: Component, load: Load, torque: float, until: float, steps: int) -> Response:
    """The same by two grids, `steps` and three times as many: their h² errors cancel (Richardson 1911)."""
    coarse = stepped(shaft, load, torque, until, steps)
    fine = stepped(shaft, load, torque, until + component.delay(shaft), THIRDS * steps)
    return Response(*(_extrapolated(a, b) for a, b in zip(coarse, fine, strict=True)))


def _extrapolated(coarse: Trace, fine: Trace) -> Trace:
    same = fine.value[THIRDS // 2 :: THIRDS][: len(coarse.value)]
    gain = THIRDS**2
    return Trace(coarse.time, (gain * same - coarse.value) / (gain - 1))
