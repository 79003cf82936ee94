"""Sticks foretold: each announced once, and each announcement held against what came."""

from dataclasses import dataclass

from vsensor.config import Rig
from vsensor.estimator.figures import STUCK_SPEED
from vsensor.grid import NS
from vsensor.messages import Estimate

LEAD_NS = NS // 5
LEAD_SHARE = 0.25
"""A stick nearer than this, or on a short string than this share of what is seen ahead, is no longer
announced: nobody could act on it."""
AGREED = 3
AGREED_SHARE = 0.1
"""So many ticks must foretell it one after the other, but no more than take this share of what is seen ahead
after the first."""
LASTING_NS = NS // 10
"""A confirmed bit that rests for so long sticks."""
TOLERANCE_NS = 3 * NS // 10
"""A stick within this of the time that was foretold is the one that was meant."""


@dataclass
class Announcement:
    """A stick that has neither come nor failed to come: when it was announced, and for when."""

    made_ns: int
    expected_ns: int


class Sticks:
    """What is foretold, and how often it came true."""

    def __init__(self, rig: Rig) -> None:
        self._rate = rig.loop.rate
        self._lasting = max(1, round(LASTING_NS / NS * rig.loop.rate))
        self._pending: list[Announcement] = []
        self._agreeing = 0
        self._resting = 0
        self._turned = False
        self._lead_ns = 0
        self.foretold = 0
        """Sticks that came as foretold;"""
        self.missed = 0
        """that came without a word;"""
        self.false = 0
        """that did not come."""

    @property
    def lead_s(self) -> float:
        """Mean time of warning of those that came, s; 0 before the first."""
        return self._lead_ns / NS / self.foretold if self.foretold else 0.0

    def forget(self) -> None:
        """Drop what is announced, uncounted: the input began anew."""
        self._pending.clear()
        self._agreeing = self._resting = 0
        self._turned = False

    def see(self, estimate: Estimate) -> Announcement | None:
        """Look at one tick's estimate; the announcement of a stick that has just become due."""
        if estimate.HasField("confirmed_time_ns"):
            self._hold_against(estimate.confirmed_time_ns, abs(estimate.confirmed_bit_speed_rad_s))
        if not (estimate.HasField("stick_in_s") and estimate.HasField("forecast_time_ns")):
            self._agreeing = 0
            return None
        ahead_ns, due_ns = estimate.forecast_time_ns - estimate.time_ns, round(estimate.stick_in_s * NS)
        self._agreeing = self._agreeing + 1 if due_ns >= min(LEAD_NS, LEAD_SHARE * ahead_ns) else 0
        needed = min(AGREED, 1 + int(AGREED_SHARE * ahead_ns / NS * self._rate))
        return self._announce(estimate.time_ns, estimate.time_ns + due_ns, needed) if self._agreeing else None

    def _announce(self, now_ns: int, expected_ns: int, needed: int) -> Announcement | None:
        last = self._pending[-1] if self._pending else None
        if last is not None and abs(expected_ns - last.expected_ns) <= TOLERANCE_NS:
            last.expected_ns = expected_ns
            return None
        if self._agreeing < needed:
            return None
        self._pending.append(Announcement(now_ns, expected_ns))
        return self._pending[-1]

    def _hold_against(self, confirmed_ns: int, speed: float) -> None:
        """Count a stick that is confirmed by now, and those that should have been."""
        self._resting = self._resting + 1 if speed < STUCK_SPEED else 0
        self._turned |= self._resting == 0
        # A bit that has not turned yet does not stick, it waits.
        if self._resting == self._lasting and self._turned:
            self._turned = False
            self._came(confirmed_ns - LASTING_NS)
        overdue = confirmed_ns - LASTING_NS - TOLERANCE_NS
        still = [announced for announced in self._pending if announced.expected_ns >= overdue]
        self.false += len(self._pending) - len(still)
        self._pending = still

    def _came(self, at_ns: int) -> None:
        for announced in self._pending:
            if abs(at_ns - announced.expected_ns) <= TOLERANCE_NS:
                self.foretold += 1
                self._lead_ns += at_ns - announced.made_ns
                self._pending.remove(announced)
                return
        self.missed += 1
