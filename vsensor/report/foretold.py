"""How well it was foretold: what was said of a time, held against what was confirmed of it in the end."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from vsensor.grid import NS
from vsensor.messages import Status
from vsensor.report.ticks import Floats, Ticks, Times

WAITS_NS = 60 * NS
"""What is not confirmed by so much later never will be."""
_QUANTITIES = ("bit_speed_rad_s", "bit_torque_nm")


class Skill(NamedTuple):
    """How predictions missed what was confirmed in the end, rms; `ahead_s` before it."""

    ahead_s: Floats
    speed_rad_s: Floats
    torque_nm: Floats


class Foretold:
    """Now and forecast of every tick, held against what was confirmed in the end."""

    def __init__(self) -> None:
        self._missed = {kind: [_Missed() for _ in _QUANTITIES] for kind in ("now", "forecast")}
        self._ahead_ns, self._count = 0.0, 0

    def add(self, ticks: Ticks) -> None:
        """Add ticks, which come in the order of time."""
        for kind, at_ns in (("now", ticks.time_ns), ("forecast", ticks.forecast_ns)):
            for missed, quantity in zip(self._missed[kind], _QUANTITIES, strict=True):
                missed.confirm(ticks.confirmed_ns, ticks[f"confirmed_{quantity}"])
                missed.add(at_ns, ticks[f"{kind}_{quantity}"])
        known = np.isfinite(ticks["forecast_bit_speed_rad_s"])
        self._ahead_ns += float(np.sum((ticks.forecast_ns - ticks.time_ns)[known]))
        self._count += int(known.sum())

    def skill(self) -> Skill:
        """What they missed until now; the forecast's is told for how far ahead it was on average."""
        ahead = {"now": 0.0, "forecast": self._ahead_ns / self._count / NS if self._count else np.nan}
        rows = [(ahead[kind], *(each.rms for each in missed)) for kind, missed in self._missed.items()]
        return Skill(*np.array([row for row in rows if np.isfinite(row).all()]).reshape(-1, 3).T)


class _Missed:
    """What one kind of prediction missed of one quantity; what is not confirmed yet waits."""

    def __init__(self) -> None:
        self._when: Times = np.empty(0, np.int64)
        self._truth: Floats = np.empty(0)
        self._asked: Times = np.empty(0, np.int64)
        self._foretold: Floats = np.empty(0)
        self._squares, self._count = 0.0, 0

    @property
    def rms(self) -> float:
        return float(np.sqrt(self._squares / self._count)) if self._count else np.nan

    def confirm(self, at_ns: Times, truth: Floats) -> None:
        """Add what was confirmed."""
        known = np.isfinite(truth)
        when, told = np.append(self._when, at_ns[known]), np.append(self._truth, truth[known])
        begin = _after_leap(when)
        order = begin + np.argsort(when[begin:], kind="stable")
        self._when, self._truth = when[order], told[order]

    def add(self, at_ns: Times, foretold: Floats) -> None:
        """Add predictions for these times, and compare what can be compared by now."""
        known = np.isfinite(foretold)
        asked, told = np.append(self._asked, at_ns[known]), np.append(self._foretold, foretold[known])
        begin = _after_leap(asked)
        asked, told = asked[begin:], told[begin:]
        if len(self._when):
            first, last = self._when[0], self._when[-1]
            within = (asked >= first) & (asked <= last)  # of what was before the first nothing can be said
            missed = told[within] - np.interp(asked[within] - first, self._when - first, self._truth)
            self._squares += float(missed @ missed)
            self._count += len(missed)
            later = asked > last
            asked, told = asked[later], told[later]
            self._when, self._truth = self._when[-1:], self._truth[-1:]
        waits = asked > asked.max(initial=0) - WAITS_NS
        self._asked, self._foretold = asked[waits], told[waits]


def _after_leap(times: Times) -> int:
    """Where the times begin that come after a clock was last set back: those before are of another time."""
    leaps = np.flatnonzero(np.diff(times) < -WAITS_NS)
    return int(leaps[-1]) + 1 if len(leaps) else 0


class Counted:
    """How predictions missed at each horizon, as the sensor counted while it ran: the rms of what was told.

    Each status tells of the last minute. Those of a string of other horizons than the last are left out.
    """

    def __init__(self) -> None:
        self._ahead: Floats = np.empty(0)
        self._squares: Floats = np.empty((0, 2))
        self._count = 0

    def add(self, status: Status) -> None:
        """Add what a status tells, if it does of each horizon."""
        if not status.skill or not all(each.HasField("speed_rms_rad_s") for each in status.skill):
            return
        rows = np.array([(each.ahead_s, each.speed_rms_rad_s, each.torque_rms_nm) for each in status.skill])
        if not np.array_equal(rows[:, 0], self._ahead):
            self._ahead, self._squares, self._count = rows[:, 0], np.zeros((len(rows), 2)), 0
        self._squares = self._squares + rows[:, 1:] ** 2
        self._count += 1

    def skill(self) -> Skill:
        """The rms of all; empty where none was told."""
        return Skill(self._ahead, *np.sqrt(self._squares / max(self._count, 1)).T)


def counted(statuses: Iterable[Status]) -> Skill:
    """What these told."""
    told = Counted()
    for status in statuses:
        told.add(status)
    return told.skill()
