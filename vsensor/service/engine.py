"""Samples in, ticks and estimates out, one tick at a time: live, and where a session is made or verified.

Tables go through `offline`, by columns; `test_offline_gives_the_same_to_the_bit` holds the two together.
"""

import math
from collections.abc import Iterator

import numpy as np

from vsensor import checkpoint
from vsensor.config import Rig
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.figures import ROWS
from vsensor.estimator.kernel import (
    CONFIRMED,
    FORECAST,
    NO_FORECAST,
    NOW,
    OFF_BOTTOM,
    SPEED,
    SPEED_STD,
    STICK,
    TOP,
    TORQUE,
    TORQUE_STD,
)
from vsensor.estimator.sections import Floats
from vsensor.grid import NS
from vsensor.intake import Input, Intake
from vsensor.messages import Estimate, Event, Sample, State, Tick
from vsensor.messages.vsensor_pb2 import Quality as QualityMessage
from vsensor.quality import Reason, verdict

_KINDS = (("confirmed_bit", CONFIRMED), ("now_bit", NOW), ("forecast_bit", FORECAST), ("top", TOP))
_QUANTITIES = (
    ("speed_rad_s", SPEED),
    ("speed_std_rad_s", SPEED_STD),
    ("torque_nm", TORQUE),
    ("torque_std_nm", TORQUE_STD),
)
_FIELDS = (
    *((f"{kind}_{what}", at + column) for kind, at in _KINDS for what, column in _QUANTITIES),
    ("stick_in_s", STICK),
)


_WARMING_UP = int(Reason.WARMING_UP)
RECENT_HZ = 100.0
"""So often a second, at the most, the bit is kept for the figures of the last while: its band is 3 Hz."""


class Engine:
    """Intake and estimator of one rig."""

    def __init__(self, rig: Rig) -> None:
        self.intake = Intake(rig)
        self.estimator = Estimator(rig)
        self._apart = max(1, int(rig.loop.rate / RECENT_HZ))
        self.recent_s = self._apart / rig.loop.rate
        """Time between two columns of `recent`."""
        self.recent = np.full((ROWS, max(1, round(rig.estimator.severity_window / self.recent_s))), np.nan)
        """The bit as confirmed in the last while, and the top at its time, in no order; rows: `figures`."""
        self._newest = 0
        self._warm = False

    @property
    def warm(self) -> bool:
        """Whether the newest tick had an answer."""
        return self._warm

    @property
    def window(self) -> Floats:
        """The same, oldest first."""
        return np.roll(self.recent, -self._newest - 1, axis=1)

    def take_up(self, state: State) -> None:
        """Go on from a recorded state; ValueError where it does not fit this rig."""
        checkpoint.take_up(state, self.intake, self.estimator)

    def forget(self) -> None:
        """Forget all input; what was learned stays."""
        self.estimator.restart()
        self.recent[:] = math.nan

    def take(self, topic: str, sample: Sample | Event | None) -> Iterator[tuple[Tick, Estimate]]:
        """Take a sample (None: unreadable) or a recorded event; yield the ticks that it completes."""
        for given in self.intake.take(topic, sample):
            tick = tick_of(given)
            yield tick, self.step(tick)

    def step(self, tick: Tick) -> Estimate:
        """Run one tick. The same ticks from the same start give the same estimates, bit for bit."""
        if tick.number == 0:
            self.forget()
        if tick.longer_by_m:
            self.estimator.lengthen(tick.longer_by_m)
        flags = tick.reasons | (OFF_BOTTOM if tick.off_bottom else 0)
        flags |= NO_FORECAST if tick.forecast_shed else 0
        values, reasons = self.estimator.step(tick.motor_torque_nm, tick.motor_speed_rad_s, flags)
        self._warm = not reasons & _WARMING_UP
        if not tick.number % self._apart:
            self._newest = tick.number // self._apart % self.recent.shape[1]
            self._keep(values[CONFIRMED + SPEED], values[CONFIRMED + TORQUE])
        return self._estimate(tick, values.tolist(), reasons)

    def _keep(self, speed: float, torque: float) -> None:
        top = self.estimator.top() if self._warm else (math.nan, math.nan)
        self.recent[:, self._newest] = speed, torque, *top

    def _estimate(self, tick: Tick, values: list[float], reasons: int) -> Estimate:
        estimate = Estimate(number=tick.number, time_ns=tick.time_ns, reasons=reasons)
        estimate.quality = QualityMessage.ValueType(verdict(reasons))
        for name, at in _FIELDS:
            if not math.isnan(value := values[at]):
                setattr(estimate, name, value)
        if tick.forecast_shed:
            estimate.forecast_shed = True
        if estimate.HasField("confirmed_bit_speed_rad_s"):
            estimate.confirmed_time_ns = tick.time_ns - round(self.estimator.confirmed_delay * NS)
        if estimate.HasField("forecast_bit_speed_rad_s"):
            estimate.forecast_time_ns = tick.time_ns + round(self.estimator.forecast_horizon * NS)
        return estimate


def tick_of(given: Input) -> Tick:
    """The record of an input, exact enough to run it again."""
    tick = Tick(
        number=given.number,
        time_ns=given.time_ns,
        motor_torque_nm=given.motor_torque,
        motor_speed_rad_s=given.motor_speed,
        reasons=given.reasons,
        off_bottom=given.off_bottom,
    )
    if given.longer_by:
        tick.longer_by_m = given.longer_by
    if given.forecast_shed:
        tick.forecast_shed = True
    return tick
