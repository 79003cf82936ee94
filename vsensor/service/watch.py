"""Conditions worth telling a driller: each begins, and ends."""

import math

from vsensor.messages import Estimate, Event, Tick

STUCK_SPEED = 0.5
"""A confirmed bit speed below this (rad/s, 5 rpm) while the surface turns faster is a stuck bit."""
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
    """All conditions of one rig."""

    def __init__(self) -> None:
        self._input = Condition(
            "input_lost", "no surface samples: estimates stopped", "surface samples are back"
        )
        self._stuck = Condition(
            "stuck", "the bit stands still while the surface turns", "the bit turns again"
        )
        self._stick_slip = Condition(
            "stick_slip", "stick-slip: the bit stops in each period", "stick-slip is over"
        )
        self._slow_since_ns: int | None = None
        self.last_ns = 0

    def tick(self, tick: Tick, estimate: Estimate) -> Event | None:
        """Look at one tick: is the bit stuck?"""
        self.last_ns = tick.time_ns
        known = estimate.HasField("confirmed_bit_speed_rad_s")
        slow = (
            known
            and abs(estimate.confirmed_bit_speed_rad_s) < STUCK_SPEED
            and abs(tick.motor_speed_rad_s) > 2 * STUCK_SPEED
        )
        if not slow:
            self._slow_since_ns = None
        elif self._slow_since_ns is None:
            self._slow_since_ns = estimate.confirmed_time_ns
        since = self._slow_since_ns
        stuck = since is not None and estimate.confirmed_time_ns - since >= STUCK_S * 1e9
        return self._stuck.see(stuck, since if stuck and since is not None else estimate.confirmed_time_ns)

    def second(self, severity: float, input_lost: bool) -> list[Event]:
        """Look at the state once a second."""
        seen = (
            self._input.see(input_lost, self.last_ns),
            self._stick_slip.see(not math.isnan(severity) and severity >= STICK_SLIP, self.last_ns),
        )
        return [event for event in seen if event is not None]
