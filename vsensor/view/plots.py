"""Speed and torque over time: surface and bit, as confirmed, now and foretold, and what the string bears."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vsensor.grid import NS
from vsensor.messages import Description, Estimate, Message, Profile, Tick
from vsensor.quality import Reason
from vsensor.view import series
from vsensor.view.batches import BandLook, Batch, Colour, DotLook, Look, Measured, Points
from vsensor.view.palette import BLUE, DEEP_RED, GREY, ORANGE, PINK, VERMILION
from vsensor.view.part import Every, Part
from vsensor.view.readings import KINDS, reading
from vsensor.view.trace import Trace
from vsensor.view.units import Units

LIMITS_EVERY_NS = NS
NEARING = 0.5
"""A limit is drawn where the torque comes to this share of it: far above, it would press the curves flat."""
NEARING_NS = 10 * NS
"""For so long after it did: a torque that swings is near at each peak."""
SIGMAS = 2.0
"""Standard deviations to each side of a line that its band covers."""

_BIT: dict[str, tuple[str, Colour, float]] = {
    "confirmed": ("bit confirmed", BLUE, 3.5),
    "now": ("bit now ±2σ", ORANGE, 3.0),
    "forecast": ("bit foretold ±2σ", PINK, 3.0),
}
_LIMITS: dict[str, tuple[Colour, float]] = {"at surface": (DEEP_RED, 2.0), "at bit": (VERMILION, 2.0)}
_SURFACE = {"speed": (series.SPEED, Reason.STALE_SPEED), "torque": (series.TORQUE, Reason.STALE_TORQUE)}


@dataclass
class Drive:
    """Between motor and string: the surface is drawn as the string feels it."""

    gear_ratio: float = 1.0
    efficiency: float = 1.0


class Plots(Part):
    """Both plots."""

    def __init__(self, units: Units, drive: Drive) -> None:
        self._units = units
        self._drive = drive
        self._lines = {series.surface(plot): Trace() for plot, _ in _SURFACE.values()}
        self._lines |= {series.limit(where): Trace() for where in _LIMITS}
        self._bit = {(plot, kind): Trace() for plot in (series.SPEED, series.TORQUE) for kind in KINDS}
        self._present: Estimate | None = None
        self._components = ("", "")
        self._looks: list[Batch] = self._looks_now()
        self._limits_due = Every(LIMITS_EVERY_NS)
        self._neared_ns: dict[str, int] = {}
        """When the torque at either end came near its limit last."""

    def take(self, message: Message) -> None:
        """Take in one message."""
        match message:
            case Tick():
                self._take_tick(message)
            case Estimate():
                self._take_estimate(message)
            case Profile():
                self._take_limits(message)
            case Description():
                self._take_description(message)

    def batches(self) -> Iterator[Batch]:
        """Hand over what has come since the last call."""
        yield from self._looks
        self._looks = []
        for entity, trace in self._lines.items():
            times, values = trace.take()
            if times.size:
                yield Points(entity, times, values[:, 0])
        for (plot, kind), trace in self._bit.items():
            times, values = trace.take()
            if times.size:
                yield Measured(series.bit(plot, kind), times, values[:, 0], SIGMAS * values[:, 1])
        yield from self._mark_present()

    def _mark_present(self) -> Iterator[Batch]:
        if self._present is None:
            return
        now = reading(self._present, "now", self._units)
        self._present = None
        for plot, value in ((series.SPEED, now.speed), (series.TORQUE, now.torque)):
            if math.isfinite(value):
                yield Points(series.present(plot), np.array([now.time_ns]), np.array([value]))

    def _take_tick(self, tick: Tick) -> None:
        """A held value was not measured, and is not drawn as if it were."""
        held = Reason(tick.reasons)
        speed = math.nan if held & Reason.STALE_SPEED else tick.motor_speed_rad_s
        torque = math.nan if held & Reason.STALE_TORQUE else tick.motor_torque_nm
        speed *= self._units.speed_factor / self._drive.gear_ratio
        torque *= self._units.torque_factor * self._drive.gear_ratio * self._drive.efficiency
        self._lines[series.surface(series.SPEED)].add(tick.time_ns, speed)
        self._lines[series.surface(series.TORQUE)].add(tick.time_ns, torque)

    def _take_estimate(self, estimate: Estimate) -> None:
        self._present = estimate
        for kind in KINDS:
            found = reading(estimate, kind, self._units)
            self._bit[series.SPEED, kind].add(found.time_ns, found.speed, found.speed_std)
            self._bit[series.TORQUE, kind].add(found.time_ns, found.torque, found.torque_std)

    def _take_limits(self, profile: Profile) -> None:
        if not profile.torque_limit_nm:
            return
        at_ns = profile.time_ns
        due = self._limits_due.due(at_ns)
        for where, end in zip(_LIMITS, (0, -1), strict=True):
            limit_nm = profile.torque_limit_nm[end]
            if abs(profile.torque_nm[end]) >= NEARING * limit_nm:
                self._neared_ns[where] = at_ns
            neared = where in self._neared_ns and at_ns - self._neared_ns[where] < NEARING_NS
            if due:
                shown_nm = limit_nm if neared else math.nan
                self._lines[series.limit(where)].add(at_ns, shown_nm * self._units.torque_factor)

    def _take_description(self, description: Description) -> None:
        self._drive.gear_ratio = description.gear_ratio
        self._drive.efficiency = description.efficiency
        names = description.component
        ends = (f": {names[0]}", f": {names[-1]}") if names else self._components
        if ends != self._components:
            self._components = ends
            self._looks = self._looks_now()

    def _looks_now(self) -> list[Batch]:
        """How everything is drawn; the legend tells which component each limit is of, once it is known."""
        looks: list[Batch] = []
        for plot in (series.SPEED, series.TORQUE):
            looks.append(Look(series.surface(plot), "surface", GREY, 1.5))
            looks += [BandLook(series.bit(plot, kind), *look) for kind, look in _BIT.items()]
            looks.append(DotLook(series.present(plot), "present", ORANGE, 5.0))
        for (where, (colour, width)), component in zip(_LIMITS.items(), self._components, strict=True):
            looks.append(Look(series.limit(where), f"limit {where}{component}", colour, width))
        return looks
