"""Conditions worth telling a driller: each begins, and ends."""

import math
from collections import deque

from vsensor.config import Rig
from vsensor.intake import NS
from vsensor.messages import Estimate, Event, Tick

STUCK_SPEED = 0.5
"""A confirmed bit speed below this (rad/s, 5 rpm) while the surface turns twice as fast is a stuck bit."""
STUCK_S = 0.3
"""for at least so long: shorter stops are the turning points of an oscillation."""
STICK_SLIP = 1.0
"""Severity from which the bit stops in each period."""


class Condition:
    """One condition, told when it begins and when it ends."""

    def __init__(self, name: str, begins: str, ends: str) -> None:
        self._name = name
        self._texts = {True: begins, False: ends}
        self.holds = False

    def see(self, holds: bool, time_ns: int) -> Event | None:
        """Take the condition's present state; an event where it has changed."""
        if holds == self.holds:
            return None
        self.holds = holds
        return Event(time_ns=time_ns, name=self._name, begins=holds, text=self._texts[holds])


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

    def second(self, severity: float, input_lost: bool) -> list[Event]:
        """Look at the state once a second."""
        seen = (
            self._input.see(input_lost, self._last_ns),
            self._stick_slip.see(not math.isnan(severity) and severity >= STICK_SLIP, self._last_ns),
        )
        return [event for event in seen if event is not None]
