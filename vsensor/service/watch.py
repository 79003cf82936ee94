"""Conditions worth telling a driller: each begins, and ends."""

import math
from collections import deque

from vsensor.config import Rig
from vsensor.estimator.figures import STUCK_SPEED
from vsensor.intake import NS
from vsensor.messages import Estimate, Event, Profile, Tick
from vsensor.messages.vsensor_pb2 import BAD

STUCK_S = 0.3
"""A bit that is slower than STUCK_SPEED for at least so long, while the surface turns twice as fast, is
stuck: shorter stops are the turning points of an oscillation."""
STICK_SLIP = 1.0
"""Severity from which the bit stops in each period."""


RELIEVED = 0.05
"""Over-torque ends once the least margin is this again: noise on the torque does not end and begin it."""


class Condition:
    """One condition, told when it begins and when it ends."""

    def __init__(self, name: str, begins: str, ends: str) -> None:
        self._name = name
        self._texts = {True: begins, False: ends}
        self.holds = False

    def see(self, holds: bool, time_ns: int, details: str = "") -> Event | None:
        """Take the condition's present state; an event where it has changed, its text ended by `details`."""
        if holds == self.holds:
            return None
        self.holds = holds
        return Event(time_ns=time_ns, name=self._name, begins=holds, text=self._texts[holds] + details)


class Watch:
    """All conditions of one rig; a tick's confirmed answer is for `confirmed_delay` (s) before it."""

    def __init__(self, rig: Rig, confirmed_delay: float) -> None:
        self._input = Condition(
            "input_lost", "a surface channel is silent", "both surface channels speak again"
        )
        self._stuck = Condition(
            "stuck",
            "the bit stands still while the surface turns",
            "the bit turns again, or the surface has stopped too",
        )
        self._stick_slip = Condition(
            "stick_slip", "stick-slip: the bit stops in each period", "stick-slip is over"
        )
        self._over_torque = Condition(
            "over_torque",
            "a component bears more torque than it may: ",
            "no component bears more torque than it may: ",
        )
        self._turning = 2 * STUCK_SPEED * rig.top_drive.gear_ratio
        self._surface: deque[float] = deque(maxlen=round(confirmed_delay * rig.loop.rate) + 1)
        """Motor speed, from the time of the confirmed answer on: surface and bit are compared at one time."""
        self._slow_since_ns: int | None = None
        self._last_ns = 0

    def tick(self, tick: Tick, estimate: Estimate) -> Event | None:
        """Look at one tick: is the bit stuck?"""
        self._last_ns = tick.time_ns
        if tick.number == 0:
            self._surface.clear()
        self._surface.append(tick.motor_speed_rad_s)
        known = estimate.HasField("confirmed_bit_speed_rad_s")
        time_ns = estimate.confirmed_time_ns if known else tick.time_ns
        slow = known and abs(estimate.confirmed_bit_speed_rad_s) < STUCK_SPEED
        if not slow or abs(self._surface[0]) < self._turning:
            self._slow_since_ns = None
            return self._stuck.see(False, time_ns)
        if self._slow_since_ns is None:
            self._slow_since_ns = time_ns
        stuck = time_ns - self._slow_since_ns >= STUCK_S * NS
        return self._stuck.see(stuck, self._slow_since_ns)

    def profile(self, profile: Profile) -> Event | None:
        """Look along the string: does a component bear more torque than it may?"""
        if profile.quality == BAD or not profile.HasField("weakest_margin"):
            return None
        over = profile.weakest_margin < (RELIEVED if self._over_torque.holds else 0.0)
        details = (
            f"{profile.weakest_component}, {profile.weakest_depth_m:.0f} m down, bears "
            f"{abs(profile.weakest_torque_nm) / 1e3:.1f} kN·m of {profile.weakest_limit_nm / 1e3:.1f} kN·m "
            f"({profile.weakest_limited_by})"
        )
        return self._over_torque.see(over, profile.time_ns, details)

    def second(self, severity: float, input_lost: bool) -> list[Event]:
        """Look at the state once a second."""
        seen = (
            self._input.see(input_lost, self._last_ns),
            self._stick_slip.see(not math.isnan(severity) and severity >= STICK_SLIP, self._last_ns),
        )
        return [event for event in seen if event is not None]
