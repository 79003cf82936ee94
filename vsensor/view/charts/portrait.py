"""The bit's torque against its speed: what the rock asks, and the law that was learned of it."""

from collections import deque
from collections.abc import Iterator

import numpy as np

from vsensor.messages import Estimate, Message, Status
from vsensor.view.batches import Batch, Floats
from vsensor.view.charts.chart import Chart, Scale
from vsensor.view.palette import BLUE, VERMILION, WHITE
from vsensor.view.part import Every, Part
from vsensor.view.readings import reading
from vsensor.view.units import Units
from vsensor.view.verdicts import STANDS

EVERY_NS = 500_000_000
SPACING_NS = 20_000_000
RECENT_S = 2.0
"""So much of the way is drawn bright."""


class Portrait(Part):
    """The way of the confirmed bit over the last `span_s` seconds, in the plane of speed and torque."""

    def __init__(self, entity: str, units: Units, span_s: float) -> None:
        self._units = units
        self._chart = Chart(entity, f"bit speed, {units.speed}", f"bit torque, {units.torque}")
        self._x, self._y = Scale(0.0), Scale(0.0)
        self._way: deque[tuple[float, float]] = deque(maxlen=round(span_s * 1e9 / SPACING_NS))
        self._last_ns = 0
        self._status = Status()
        self._every = Every(EVERY_NS)

    def take(self, message: Message) -> None:
        """Take in a confirmed answer, or the law in force."""
        if isinstance(message, Status):
            self._status = message
        elif isinstance(message, Estimate) and abs(message.time_ns - self._last_ns) >= SPACING_NS:
            self._last_ns = message.time_ns
            bit = reading(message, "confirmed", self._units)
            self._way.append((bit.speed, bit.torque))

    def batches(self) -> Iterator[Batch]:
        """The way and the law, twice a second."""
        if len(self._way) < 2 or not self._every.due(self.at_ns):
            return
        speeds, torques = np.array(self._way).T
        if not np.isfinite(speeds).any():
            return
        law_speeds, law_torques = self._law(speeds)
        x = self._x.follow(np.where(np.abs(speeds) < STANDS * self._units.speed_factor, 0.0, speeds))
        y = self._y.follow(np.concatenate([torques, law_torques]))
        yield from self._chart.frame(self.at_ns, x, y)
        yield self._chart.curve("way", self.at_ns, speeds, torques, (*BLUE[:3], 90), 1.0)
        recent = round(RECENT_S * 1e9 / SPACING_NS)
        yield self._chart.curve("way/recent", self.at_ns, speeds[-recent:], torques[-recent:], WHITE, 2.0)
        entries = [("the bit", BLUE), (f"last {RECENT_S:g} s", WHITE)]
        if len(law_speeds):
            yield self._chart.curve("way/law", self.at_ns, law_speeds, law_torques, VERMILION, 3.0)
            entries.append(("learned law", VERMILION))
        yield self._chart.legend(self.at_ns, entries)

    def _law(self, speeds: Floats) -> tuple[Floats, Floats]:
        """The law over the speeds that were seen, backwards only where the bit did turn back."""
        if not self._status.HasField("law_kinetic_nm"):
            return np.empty(0), np.empty(0)
        slowest, fastest = float(np.nanmin(speeds)), float(np.nanmax(speeds))
        back = slowest < -STANDS * self._units.speed_factor
        asked = np.linspace(slowest if back else 0.0, max(fastest, 1e-6), 400)
        # A bit that turns hardly at all: the law's own value at rest is anything up to the static torque.
        turning = np.where(asked == 0, 1e-9, asked)
        return asked, law(self._status, turning / self._units.speed_factor) * self._units.torque_factor


def law(status: Status, speeds: Floats) -> Floats:
    """The load law in force: torque that the rock asks, N·m, at speeds in rad/s, shape (n,).

    Viscous, and Coulomb that falls with speed from static to kinetic (Stribeck).
    """
    fall = (status.law_static_nm - status.law_kinetic_nm) * np.exp(
        -np.abs(speeds) / status.law_stribeck_rad_s
    )
    return status.law_viscous_nm_s_rad * speeds + np.sign(speeds) * (status.law_kinetic_nm + fall)
