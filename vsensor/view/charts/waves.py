"""What the string's delay lines hold: the wave that travels down it, and the one that travels up."""

from collections.abc import Iterator

import numpy as np

from vsensor.view.batches import Batch
from vsensor.view.charts.chart import Chart, Scale, axis
from vsensor.view.palette import BLUE, ORANGE
from vsensor.view.part import AlongString, Every
from vsensor.view.units import Units

EVERY_NS = 200_000_000


class Waves(AlongString):
    """Both waves against depth, from the newest profile: T + ζω goes down, T − ζω up."""

    def __init__(self, entity: str, units: Units) -> None:
        super().__init__()
        self._factor = units.torque_factor
        self._chart = Chart(entity, f"wave, {units.torque}", "depth, m", y_down=True)
        self._scale = Scale(0.0)
        self._every = Every(EVERY_NS)

    def batches(self) -> Iterator[Batch]:
        """Both curves, five times a second, as soon as the string's impedance is known."""
        depth = np.array(self._profile.depth_m)
        impedance = np.array(self._description.impedance_nm_s_rad)
        if not len(depth) or len(depth) != len(impedance) or not self._every.due(self.at_ns):
            return
        torque = np.array(self._profile.torque_nm) * self._factor
        swing = impedance * self._profile.speed_rad_s * self._factor
        down, up = torque + swing, torque - swing
        x = self._scale.follow(np.concatenate([down, up]))
        yield from self._chart.frame(self.at_ns, x, axis(0.0, float(depth[-1])))
        yield self._chart.curve("down", self.at_ns, down, depth, BLUE, 3.0)
        yield self._chart.curve("up", self.at_ns, up, depth, ORANGE, 3.0)
        yield self._chart.legend(self.at_ns, [("down: T + ζω", BLUE), ("up: T − ζω", ORANGE)])
