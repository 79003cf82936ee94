"""Samples of two channels, late, lost or doubled, onto the tick's grid.

The grid is laid over the source's own time, and a tick is given out as soon as both channels reach
it. No clock of ours takes part, so the same samples in the same order give the same ticks, live,
offline or replayed.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vsensor.commands import COMMAND, obey
from vsensor.config import Rig
from vsensor.depth import Depths
from vsensor.errors import InputError
from vsensor.grid import NS, Grid
from vsensor.intake.channel import FARTHEST_NS, Channel, a_time
from vsensor.intake.frozen import Frozen
from vsensor.intake.given import Input
from vsensor.intake.reach import Reach, rate_of
from vsensor.intake.sound import Laid, refuse_unsound
from vsensor.messages import DEPTH_TOPICS, SURFACE_SPEED, SURFACE_TORQUE, Event, Sample
from vsensor.quality import Reason
from vsensor.saved import Saved

FORECAST_SHED = "forecast_shed"
"""The name of an event: the loop was short of time from here on, or no longer, and foretold nothing."""
OBEYED = (COMMAND, FORECAST_SHED)
"""Names of recorded events that change what comes of the samples behind them."""
_STRING_CHANGED, _GAP_BRIDGED = int(Reason.STRING_CHANGED), int(Reason.GAP_BRIDGED)


class Intake:
    """Two channels onto one grid of ticks."""

    def __init__(self, rig: Rig) -> None:
        measured = rig.measurement
        self._grid = Grid(rig.loop.rate)
        self.max_gap_ns = round(measured.max_gap * NS)
        self._restart_gap_ns = round(measured.restart_gap * NS)
        turns = rig.top_drive.gear_ratio
        highest, fastest = measured.torque_limit / turns, measured.speed_limit * turns
        changes = turns * rate_of(measured.torque_limit, rig.top_drive.inertia)
        self._torque = Channel(
            SURFACE_TORQUE,
            highest,
            measured.torque_noise,
            Reason.STALE_TORQUE,
            Reach(math.inf, highest, self._restart_gap_ns),
            self.max_gap_ns,
        )
        self._speed = Channel(
            SURFACE_SPEED,
            fastest,
            measured.speed_noise,
            Reason.STALE_SPEED,
            Reach(changes, fastest, self._restart_gap_ns),
            self.max_gap_ns,
        )
        self.channels = {SURFACE_TORQUE: self._torque, SURFACE_SPEED: self._speed}
        self.depths = Depths(rig)
        self.frozen = Frozen(rig)
        self.restarts = 0
        self.forecast_shed = False
        """Whether the loop is short of time for a forecast."""
        self._jump_ns: dict[str, int] = {}
        self._lay_anew()

    def _lay_anew(self) -> None:
        self._anchor_ns: int | None = None
        self._number = 0
        self._consumed_ns: int | None = None
        for channel in self.channels.values():
            channel.forget()
        self.frozen.forget()

    def save(self) -> dict[str, Any]:
        """What is remembered between two samples, but for the counts, as plain values."""
        return {
            "anchor_ns": self._anchor_ns,
            "number": self._number,
            "consumed_ns": self._consumed_ns,
            "jump_ns": self._jump_ns,
            "forecast_shed": self.forecast_shed,
            "channels": {topic: channel.save() for topic, channel in self.channels.items()},
            "depths": self.depths.save(),
            "frozen": self.frozen.save(),
        }

    def restore(self, told: object) -> None:
        """Take up what `save` gave, or an older version: the same samples then give the same ticks.

        Raises ValueError for what it cannot have given, and is then of no use any more.
        """
        saved = Saved(told, "intake")
        self._anchor_ns = saved["anchor_ns"].or_none(a_time)
        self._number = saved["number"].whole(0, 1 << 64)
        self._consumed_ns = saved["consumed_ns"].or_none(a_time)
        self._jump_ns = {topic: a_time(jump) for topic, jump in saved["jump_ns"].items(self.channels)}
        self.forecast_shed = saved["forecast_shed"].flag()
        for topic, channel in self.channels.items():
            channel.restore(saved["channels"][topic])
        self.depths.restore(saved["depths"])
        self.frozen.forget()
        saved.get("frozen", None).or_none(self.frozen.restore)
        reach_ns = 3 * self._restart_gap_ns + 2 * self.max_gap_ns
        laid = Laid(self._anchor_ns, self._number, self._consumed_ns)
        refuse_unsound(saved, laid, self._grid, self.channels, reach_ns)

    def take(self, topic: str, sample: Sample | Event | None) -> list[Input]:
        """Take one sample in the order of arrival, None for one that could not be read.

        Returns each tick that both channels have now reached, or that one has left far behind.
        Recorded events of OBEYED are obeyed again; raises InputError where this rig cannot.
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
        if channel.believes(sample) and channel.is_new(sample):
            if channel.falls_back(sample) and all(each.clock.fell_back for each in self.channels.values()):
                self._begin_anew()
            waiting = channel.waiting
            if waiting is not None and 0 < sample.time_ns - waiting.time_ns <= self._restart_gap_ns:
                channel.settle(sample.value, self._consumed_ns)
            if self._in_time(topic, channel, sample.time_ns):
                channel.take(sample, self._consumed_ns, self.max_gap_ns)
        channel.follow(sample)
        return list(self._ready())

    @property
    def off_bottom(self) -> bool:
        """Whether the bit was held to be off bottom at the newest tick, or is told to be at the first."""
        return self.depths.off_bottom(self._consumed_ns or 0)

    @property
    def depths_silent(self) -> bool:
        """Whether, at the newest tick, a channel that has told a depth tells none any longer."""
        return self._consumed_ns is not None and self.depths.silent(self._consumed_ns)

    @property
    def contested(self) -> tuple[str, ...]:
        """The topics of channels that two publishers tell."""
        return tuple(topic for topic, channel in self.channels.items() if channel.sequence.contested)

    @property
    def beats(self) -> tuple[int, int]:
        """How often each reading of torque and of speed is told; 0 where as often as it is read."""
        return self._torque.repeats.heard.beat, self._speed.repeats.heard.beat

    @property
    def hole(self) -> tuple[int, int]:
        """Where, in time, both channels have a hole though no sample of them is missing: from, to."""
        return self._torque.clock.hole_with(self._speed.clock)

    @property
    def next_number(self) -> int:
        """The number of the tick that comes next, if no grid is laid anew before."""
        return self._number

    @property
    def is_laid(self) -> bool:
        """Whether there is a grid: both channels have spoken."""
        return self._anchor_ns is not None

    def ticks_until(self, time_ns: int) -> NDArray[np.int64]:
        """The times of the next ticks that come no later than some time; none where no grid is laid."""
        if self._anchor_ns is None:
            return np.empty(0, np.int64)
        return self._anchor_ns + self._grid.until_ns(self._number, time_ns - self._anchor_ns)

    def pass_over(self, times_ns: NDArray[np.int64]) -> int:
        """Hold the next ticks, at these times, for given out; returns the first one's number."""
        first = self._number
        if len(times_ns):
            self._number += len(times_ns)
            self._consumed_ns = int(times_ns[-1])
        self._jump_ns.clear()
        return first

    def let_go(self) -> None:
        """Drop the points that the next tick has no need of."""
        if self._anchor_ns is not None:
            for channel in self.channels.values():
                channel.let_go(self._anchor_ns + self._grid.after_ns(self._number))

    def refuse_unread(self, topic: str) -> None:
        """Count a sample that came too fast to be looked at."""
        if topic in DEPTH_TOPICS:
            self.depths.refuse()
        else:
            self.channels[topic].refuse_unread()

    def _obey_again(self, event: Event) -> None:
        if event.name == FORECAST_SHED:
            self.forecast_shed = event.begins
        if event.name != COMMAND:
            return
        try:
            obey(event.text, self.depths)
        except ValueError as error:
            raise InputError(f"the recorded command {event.text!r} does not fit this rig: {error}") from error

    def _in_time(self, topic: str, channel: Channel, time_ns: int) -> bool:
        """Whether a time follows from what came before.

        One sample with a time far off is refused. A second that follows it means that the source's
        clock was set, or that the link was cut for long: then all begins anew.
        """
        if abs(time_ns) > FARTHEST_NS:
            channel.counts.jumped += 1
            return False
        own = channel.newest_ns
        if own is not None and abs(time_ns - own) <= self._restart_gap_ns:
            self._jump_ns.pop(topic, None)
            return True
        times = [t for c in self.channels.values() if (t := c.newest_ns) is not None]
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
        self._begin_anew()
        return True

    def _begin_anew(self) -> None:
        self._jump_ns.clear()
        self._lay_anew()
        self.restarts += 1

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
        time_ns = self._anchor_ns + self._grid.after_ns(self._number)
        torque_ns, speed_ns = self._torque.points[-1].time_ns, self._speed.points[-1].time_ns
        not_reached = torque_ns < time_ns or speed_ns < time_ns
        if not_reached and max(torque_ns, speed_ns) <= time_ns + self.max_gap_ns:  # and none is far ahead
            self._torque.let_go(time_ns)
            self._speed.let_go(time_ns)
            return None
        torque = self._value(self._torque, self._speed, time_ns)
        speed = self._value(self._speed, self._torque, time_ns)
        if torque is None or speed is None:
            return None
        reasons = torque[1] | speed[1]
        if time_ns < self._torque.clock.hole[1] and self.hole[0] < time_ns < self.hole[1]:
            reasons |= _GAP_BRIDGED
        reasons |= self.frozen.take(torque[0], speed[0], reasons)
        if longer_by := self.depths.longer_by():
            reasons |= _STRING_CHANGED
        given = Input(
            self._number,
            time_ns,
            torque[0],
            speed[0],
            reasons,
            self.depths.off_bottom(time_ns),
            longer_by,
            self.forecast_shed,
        )
        self._number += 1
        self._consumed_ns = time_ns
        return given

    def _value(self, channel: Channel, other: Channel, time_ns: int) -> tuple[float, int] | None:
        value = channel.at(time_ns, self.max_gap_ns)
        if value is None:
            patience_ns = min(channel.patience_ns(self.max_gap_ns), self._restart_gap_ns)
            if other.has_gone_on(time_ns, self.max_gap_ns + patience_ns):
                return channel.held()
        return value
