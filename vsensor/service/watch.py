"""Conditions worth telling a driller: each begins, and ends."""

import math
import time
from collections.abc import Sequence

from vsensor.commands import COMMAND
from vsensor.config import Rig
from vsensor.depth import Depths
from vsensor.estimator.figures import STUCK_SPEED
from vsensor.grid import NS
from vsensor.intake import FORECAST_SHED
from vsensor.messages import Estimate, Event, Profile, Tick
from vsensor.messages.vsensor_pb2 import BAD
from vsensor.service.clocks import Clocks
from vsensor.service.shed import NO_FORECAST, NO_PROFILE
from vsensor.service.sticks import Sticks

STUCK_S = 0.3
"""A bit that is slower than STUCK_SPEED for at least so long, while the surface turns twice as fast, is
stuck: shorter stops are the turning points of an oscillation."""
STICK_SLIP = 1.0
"""Severity from which the bit stops in each period."""
STANDING_S = 15.0
"""A string that has stood still for so long hangs in slips: a bit's stick is over sooner."""
RPM = 30 / math.pi
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
    """All conditions of one rig."""

    def __init__(self, rig: Rig) -> None:
        self.sticks = Sticks(rig)
        self._input = Condition(
            "input_lost",
            "a surface channel is silent, or both repeat their last readings",
            "both surface channels speak again",
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
        self._off_bottom = Condition("off_bottom", "the bit is off bottom", "the bit is held to be on bottom")
        self._connection = Condition(
            "connection", "the string stands still, as for a connection", "the string turns again"
        )
        self._depths = Condition(
            "depths_at_odds",
            "the bit's depth and the string's length differ by more than a connection could: ",
            "the bit's depth and the string's length agree again: ",
        )
        self._depths_silent = Condition(
            "depths_silent",
            "a depth channel is silent, or its clock is apart: the bit is held to be on bottom unless told",
            "the depths are told again",
        )
        self._noisier = Condition(
            "noisier",
            "torque and speed are noisier than told: ",
            "torque and speed are no noisier than told any longer",
        )
        self._repeated = Condition(
            "repeated",
            "a channel repeats its readings, and what repeats one is no new reading: ",
            "no channel repeats its readings any longer",
        )
        self._contested = Condition(
            "contested",
            "two publishers tell one channel, and neither is heeded: ",
            "each channel is told by one publisher again",
        )
        self._clocks_apart = Condition(
            "clocks_apart", "the channels' clocks are apart: ", "the channels' clocks agree again"
        )
        self._clocks = Clocks(rig)
        self._no_profile = Condition(
            "profile_shed",
            "the loop is short of time: no profile is told",
            "the loop has time again for the profile",
        )
        self._no_forecast = Condition(
            FORECAST_SHED,
            "the loop is short of time: nothing is foretold",
            "the loop has time again for the forecast",
        )
        self._turning = 2 * STUCK_SPEED * rig.top_drive.gear_ratio
        """Motor speed from which the string turns, rad/s."""
        self._slow_since_ns: int | None = None
        self._turned_ns: int | None = None
        self._tuning: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0)
        self._last_ns = time.time_ns()  # until the first tick tells the source's own time

    def tick(self, tick: Tick, estimate: Estimate) -> list[Event]:
        """Look at one tick: what does the bit do, and what was done to the string?"""
        self._last_ns = tick.time_ns
        if tick.number == 0:
            self._turned_ns = None
            self.sticks.forget()
        seen = (
            self._look_at_bit(tick, estimate),
            self._look_at_string(tick),
            self._off_bottom.see(tick.off_bottom, tick.time_ns),
            self._look_for_connection(tick),
            self._look_ahead(estimate),
        )
        return [event for event in seen if event is not None]

    def _look_at_bit(self, tick: Tick, estimate: Estimate) -> Event | None:
        known = estimate.HasField("confirmed_bit_speed_rad_s")
        time_ns = estimate.confirmed_time_ns if known else tick.time_ns
        slow = known and abs(estimate.confirmed_bit_speed_rad_s) < STUCK_SPEED
        if not slow or abs(estimate.top_speed_rad_s) < 2 * STUCK_SPEED:
            self._slow_since_ns = None
            return self._stuck.see(False, time_ns)
        if self._slow_since_ns is None:
            self._slow_since_ns = time_ns
        stuck = time_ns - self._slow_since_ns >= STUCK_S * NS
        return self._stuck.see(stuck, self._slow_since_ns)

    def _look_at_string(self, tick: Tick) -> Event | None:
        if not tick.longer_by_m:
            return None
        text = (
            f"the string is {abs(tick.longer_by_m):.1f} m {'longer' if tick.longer_by_m > 0 else 'shorter'}"
        )
        return Event(time_ns=tick.time_ns, name="string_changed", begins=True, text=text)

    def _look_for_connection(self, tick: Tick) -> Event | None:
        """The string has turned and stands still: since when is known once it has lasted."""
        if abs(tick.motor_speed_rad_s) >= self._turning:
            self._turned_ns = tick.time_ns
            return self._connection.see(False, tick.time_ns)
        if self._turned_ns is None or tick.time_ns - self._turned_ns < STANDING_S * NS:
            return None
        return self._connection.see(True, self._turned_ns)

    def _look_ahead(self, estimate: Estimate) -> Event | None:
        announced = self.sticks.see(estimate)
        if announced is None:
            return None
        lead_s = (announced.expected_ns - announced.made_ns) / NS
        text = f"the bit is going to stick in {lead_s:.1f} s"
        return Event(time_ns=announced.made_ns, name="stick_foretold", begins=True, text=text)

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

    def shedding(self, level: int) -> list[Event]:
        """Look at what the loop leaves out."""
        seen = (
            self._no_profile.see(level >= NO_PROFILE, self._last_ns),
            self._no_forecast.see(level >= NO_FORECAST, self._last_ns),
        )
        return [event for event in seen if event is not None]

    def learned(
        self, tuning: Sequence[float], noisier: float, steps: Sequence[float], lasts: float
    ) -> list[Event]:
        """Look at what the record has told of the rig.

        Corrections in force: shares of delay, impedance, inertia and friction, the torque's offset, N·m. By
        what factor the channels are noisier than told, the steps, N·m and rad/s, in which they are read, or
        0, and how many ticks a reading of speed lasts, 1 or more.
        """
        seen = (self._look_at_corrections(*tuning), self._look_at_noise(noisier, steps, lasts))
        return [event for event in seen if event is not None]

    def _look_at_noise(self, noisier: float, steps: Sequence[float], lasts: float) -> Event | None:
        torque_step, speed_step = steps
        details = f"by {noisier:.1f} times"
        if torque_step:
            details += f", torque is read in steps of {torque_step:.3g} N·m"
        if speed_step:
            details += f", speed is read in steps of {speed_step * RPM:.3g} rpm"
        if lasts > 1:
            details += f", speed is read once in {lasts:.0f} ticks"
        return self._noisier.see(noisier > 1, self._last_ns, details if noisier > 1 else "")

    def _look_at_corrections(
        self, delay: float, impedance: float, inertia: float, friction: float, offset: float
    ) -> Event | None:
        if (now := (delay, impedance, inertia, friction, offset)) == self._tuning:
            return None
        self._tuning = now
        text = (
            f"the configuration is corrected: delay {delay:+.2%}, impedance {impedance:+.1%}, "
            f"top-drive inertia {inertia:+.1%}, wall friction {friction:+.1%}, "
            f"torque's zero {offset:+.0f} N·m"
        )
        return Event(time_ns=self._last_ns, name="self_tuning", begins=True, text=text)

    def command(self, words: str) -> Event:
        """Note what the sensor was told, in the words that tell it again."""
        return self.note(COMMAND, True, words)

    def note(self, name: str, begins: bool, text: str) -> Event:
        """An event of the present, in somebody's words."""
        return Event(time_ns=self._last_ns, name=name, begins=begins, text=text)

    def incoming(self, depths: Depths, depths_silent: bool, beats: Sequence[int]) -> list[Event]:
        """Look at what comes in: are the depths told, and do they fit the string? Is each sample a reading?

        `beats`: how often each reading of torque and of speed is told, or 0.
        """
        length = f"the string is {depths.length:.1f} m long"
        seen = (
            self._depths.see(depths.at_odds, self._last_ns, length),
            self._depths_silent.see(depths_silent, self._last_ns),
            self._look_at_repeats(beats),
        )
        return [event for event in seen if event is not None]

    def sources(self, contested: Sequence[str], newest_ns: Sequence[int | None]) -> list[Event]:
        """Look at who tells the channels: which ones two do, and the newest times of torque and of speed."""
        apart = self._clocks.apart(*newest_ns)
        seen = (
            self._contested.see(bool(contested), self._last_ns, ", ".join(contested)),
            self._clocks_apart.see(bool(apart), self._last_ns, apart),
        )
        return [event for event in seen if event is not None]

    def _look_at_repeats(self, beats: Sequence[int]) -> Event | None:
        told = zip(("torque", "speed"), beats, strict=True)
        details = ", ".join(f"{channel} {beat} times" for channel, beat in told if beat)
        return self._repeated.see(bool(details), self._last_ns, details)
