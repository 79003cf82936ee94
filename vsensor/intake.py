"""Samples of two channels, late, lost or doubled, onto the tick's grid.

The grid is laid over the source's own time, and a tick is given out as soon as both channels reach
it. No clock of ours takes part, so the same samples in the same order give the same ticks, live,
offline or replayed.
"""

import math
from bisect import insort
from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

from vsensor.commands import COMMAND, obey
from vsensor.config import Rig
from vsensor.depth import Depths
from vsensor.errors import InputError
from vsensor.messages import DEPTH_TOPICS, SURFACE_SPEED, SURFACE_TORQUE, ChannelStatus, Event, Sample
from vsensor.quality import Quality, Reason

NS = 1_000_000_000

FARTHEST_NS = 1 << 62
"""A time beyond 146 years from 1970 is none: near the end of its 64 bits, a forecast's would not fit."""
LONGEST_HOLE = 1_000_000
"""A greater leap in the sequence is another publisher's count, and no loss."""
REMEMBERED = 1000
"""How far back a missing sample's number is known, so that it is no loss if it only comes late."""


class Input(NamedTuple):
    """What the estimator is given at one tick."""

    number: int
    """Ticks since the grid was last laid; 0 means that the estimator must forget all input."""
    time_ns: int
    motor_torque: float
    motor_speed: float
    reasons: Reason
    off_bottom: bool = False
    longer_by: float = 0.0
    """By how much the string has become longer since the tick before, m."""


class Point(NamedTuple):
    """An accepted sample."""

    time_ns: int
    value: float
    reasons: Reason


class Channel:
    """One channel: what is refused and why, and the points that the grid still needs."""

    def __init__(self, name: str, limit: float, stale: Reason) -> None:
        self.counts = ChannelStatus(
            channel=name,
            received=0,
            accepted=0,
            lost=0,
            unreadable=0,
            not_finite=0,
            out_of_range=0,
            doubled=0,
            late=0,
            jumped=0,
            bad_at_source=0,
        )
        self.stale = stale
        self._limit = limit
        self._next_sequence: int | None = None
        self._missing: set[int] = set()
        self.forget()

    def forget(self) -> None:
        """Begin anew, as before the first sample; the counts stay."""
        self.points: list[Point] = []

    @property
    def newest_ns(self) -> int | None:
        """The time of the newest accepted sample."""
        return self.points[-1].time_ns if self.points else None

    def believes(self, sample: Sample) -> bool:
        """Whether value and quality of a sample can be used; counts it otherwise."""
        if not math.isfinite(sample.value):
            self.counts.not_finite += 1
        elif abs(sample.value) > self._limit:
            self.counts.out_of_range += 1
        elif int(sample.quality) == Quality.BAD:
            self.counts.bad_at_source += 1
        else:
            return True
        return False

    def follow(self, sample: Sample) -> None:
        """Follow the sequence: a hole is a loss, until the missing one comes late after all."""
        if not sample.HasField("sequence"):
            return
        given = sample.sequence
        ahead = 0 if self._next_sequence is None else given - self._next_sequence
        if given in self._missing:
            self._missing.remove(given)
            self.counts.lost -= 1
        elif 0 <= ahead <= LONGEST_HOLE:
            self.counts.lost += ahead
            self._remember(given, ahead)
            self._next_sequence = given + 1
        elif ahead > 0 or (ahead < -1 and sample.time_ns == self.newest_ns):
            # A low number with the newest time: the publisher has begun to count anew.
            self._missing.clear()
            self._next_sequence = given + 1

    def _remember(self, given: int, missing: int) -> None:
        if missing:
            known = given - REMEMBERED
            self._missing = {number for number in self._missing if number >= known}
            self._missing.update(range(max(given - missing, known), given))

    def accept(self, sample: Sample, consumed_ns: int | None) -> None:
        """Keep a sample in its place in time, unless that has passed or is taken."""
        reasons = Reason.SOURCE_UNCERTAIN if int(sample.quality) == Quality.UNCERTAIN else Reason(0)
        point = Point(sample.time_ns, sample.value, reasons)
        newest = self.newest_ns
        if newest is None or point.time_ns > newest:
            self.points.append(point)
        elif any(kept.time_ns == point.time_ns for kept in self.points):
            self.counts.doubled += 1
            return
        elif consumed_ns is not None and point.time_ns <= consumed_ns:
            self.counts.late += 1
            return
        else:
            insort(self.points, point)
        self.counts.accepted += 1

    def let_go(self, time_ns: int) -> None:
        """Drop what lies before a time, but for the last of it."""
        while len(self.points) > 1 and self.points[1].time_ns <= time_ns:
            del self.points[0]

    def at(self, time_ns: int, max_gap_ns: int) -> tuple[float, Reason] | None:
        """The value at a time by a straight line between its neighbours; None where not reached yet."""
        self.let_go(time_ns)
        before = self.points[0]
        if before.time_ns == time_ns:
            return before.value, before.reasons
        if len(self.points) == 1:
            return None
        after = self.points[1]
        reasons = before.reasons | after.reasons
        gap = after.time_ns - before.time_ns
        if gap > max_gap_ns:
            reasons |= Reason.GAP_BRIDGED
        share = (time_ns - before.time_ns) / gap
        return before.value + share * (after.value - before.value), reasons

    def has_gone_on(self, time_ns: int, max_gap_ns: int) -> bool:
        """Whether samples reach further than a gap past the first at or after a time.

        Past the time itself would not do: where both channels were silent, or are slow, one of
        them is the first to speak again, and the other a moment behind it.
        """
        following = next((point for point in self.points if point.time_ns >= time_ns), None)
        return following is not None and self.points[-1].time_ns > following.time_ns + max_gap_ns

    def held(self) -> tuple[float, Reason]:
        """The last value, for a channel that has fallen silent."""
        return self.points[0].value, self.points[0].reasons | self.stale


class Intake:
    """Two channels onto one grid of ticks."""

    def __init__(self, rig: Rig) -> None:
        measured = rig.measurement
        self._period = Fraction(NS) / Fraction(rig.loop.rate).limit_denominator(10**6)
        self._max_gap_ns = round(measured.max_gap * NS)
        self._restart_gap_ns = round(measured.restart_gap * NS)
        turns = rig.top_drive.gear_ratio
        self._torque = Channel(SURFACE_TORQUE, measured.torque_limit / turns, Reason.STALE_TORQUE)
        self._speed = Channel(SURFACE_SPEED, measured.speed_limit * turns, Reason.STALE_SPEED)
        self.channels = {SURFACE_TORQUE: self._torque, SURFACE_SPEED: self._speed}
        self.depths = Depths(rig)
        self.restarts = 0
        self._jump_ns: dict[str, int] = {}
        self._lay_anew()

    def _lay_anew(self) -> None:
        self._anchor_ns: int | None = None
        self._number = 0
        self._consumed_ns: int | None = None
        for channel in self.channels.values():
            channel.forget()

    def take(self, topic: str, sample: Sample | Event | None) -> list[Input]:
        """Take one sample in the order of arrival, None for one that could not be read.

        Returns each tick that both channels have now reached, or that one has left far behind.
        Of recorded events, commands are obeyed again; raises InputError where this rig cannot.
        """
        if isinstance(sample, Event):
            self._obey_again(sample)
            return []
        if topic in DEPTH_TOPICS:
            self.depths.take(topic, sample)
            return []
        channel = self.channels[topic]
        channel.counts.received += 1
        if sample is None:
            channel.counts.unreadable += 1
            return []
        if channel.believes(sample) and self._in_time(topic, channel, sample.time_ns):
            channel.accept(sample, self._consumed_ns)
        channel.follow(sample)
        return list(self._ready())

    def _obey_again(self, event: Event) -> None:
        if event.name != COMMAND:
            return
        try:
            obey(event.text, self.depths)
        except ValueError as error:
            raise InputError(f'the recorded command "{event.text}" does not fit this rig: {error}') from error

    def _in_time(self, topic: str, channel: Channel, time_ns: int) -> bool:
        """Whether a time follows from what came before.

        One sample with a time far off is refused. A second that follows it means that the source's
        clock was set, or that the link was cut for long: then all begins anew.
        """
        if abs(time_ns) > FARTHEST_NS:
            channel.counts.jumped += 1
            return False
        times = [t for c in self.channels.values() if (t := c.newest_ns) is not None]
        own = channel.newest_ns
        if not times or (own is None and min(times) - self._restart_gap_ns <= time_ns):
            return True
        latest = max(times) + self._restart_gap_ns
        earliest = (own if own is not None else min(times)) - self._restart_gap_ns
        if earliest <= time_ns <= latest:
            self._jump_ns.pop(topic, None)
            return True
        before = self._jump_ns.get(topic)
        if before is None or not before < time_ns <= before + self._restart_gap_ns:
            self._jump_ns[topic] = time_ns
            channel.counts.jumped += 1
            return False
        self._jump_ns.clear()
        self._lay_anew()
        self.restarts += 1
        return True

    def _ready(self) -> Iterator[Input]:
        while (given := self._next()) is not None:
            yield given

    def _next(self) -> Input | None:
        if not self._torque.points or not self._speed.points:
            # One alone may speak for hours. No tick will lie further back than where the other may begin.
            for channel in self.channels.values():
                if channel.newest_ns is not None:
                    channel.let_go(channel.newest_ns - self._restart_gap_ns)
            return None
        if self._anchor_ns is None:
            self._anchor_ns = max(self._torque.points[0].time_ns, self._speed.points[0].time_ns)
        time_ns = self._anchor_ns + self._number * self._period.numerator // self._period.denominator
        torque = self._value(self._torque, self._speed, time_ns)
        speed = self._value(self._speed, self._torque, time_ns)
        if torque is None or speed is None:
            return None
        longer_by = self.depths.longer_by()
        changed = Reason.STRING_CHANGED if longer_by else Reason(0)
        reasons = torque[1] | speed[1] | changed
        given = Input(self._number, time_ns, torque[0], speed[0], reasons, self.depths.off_bottom, longer_by)
        self._number += 1
        self._consumed_ns = time_ns
        return given

    def _value(self, channel: Channel, other: Channel, time_ns: int) -> tuple[float, Reason] | None:
        value = channel.at(time_ns, self._max_gap_ns)
        if value is None and other.has_gone_on(time_ns, self._max_gap_ns):
            return channel.held()
        return value
