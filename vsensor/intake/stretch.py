"""Samples by columns laid on the tick's grid together.

Where they come as they should, in turn, each later than the one before and none missing, all their ticks
are had at once. What is in any way out of order goes to the intake one by one; which of the two ways a
sample went cannot be told from the ticks, nor from the books.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.intake.arrivals import Arrivals, Floats, Inputs, Integers, by_columns
from vsensor.intake.channel import FARTHEST_NS, Channel, Point
from vsensor.intake.intake import Intake
from vsensor.intake.repeats import Heard
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE
from vsensor.quality import Quality, Reason

FEWEST = 64
"""So few samples are sooner taken one by one."""
MOST = 1 << 16
"""Samples looked at together: the ticks of so many are in memory at once."""


def laid(intake: Intake, arrivals: Arrivals) -> Iterator[Inputs]:
    """Take samples in the order of arrival; yield the ticks that they complete, as `Intake.take` does."""
    count = len(arrivals.time_ns)
    if count > MOST:
        for start in range(0, count, MOST):
            yield from laid(intake, arrivals.part(start, start + MOST))
    elif (stretch := Stretch.of(intake, arrivals)) is not None:
        yield stretch.lay(intake)
    elif count > FEWEST:
        yield from laid(intake, arrivals.part(0, count // 2))
        yield from laid(intake, arrivals.part(count // 2, count))
    else:
        yield by_columns(tick for topic, sample in arrivals.samples() for tick in intake.take(topic, sample))


class Track(NamedTuple):
    """A channel's points: those that the intake still holds, and those that come."""

    channel: Channel
    times: Integers
    values: Floats
    kept: NDArray[np.bool_]
    """Which of the n samples that come are points, shape (n,):"""
    strays: int
    """these are none,"""
    heard: Heard
    """nor what repeats a reading."""
    changes: Floats
    """From one reading to the next."""
    sequence: int | None
    """The last number, None where they have none;"""
    told_ns: int
    """the last one's time,"""
    apart: list[int] | None
    """and how far apart they are in time, where they have numbers."""

    @staticmethod
    def of(channel: Channel, arrivals: Arrivals, limits: tuple[float, int]) -> "Track | None":
        """The track of one channel's samples; None where they are not in the best of order.

        `limits` are the largest value that is believed, and the longest gap (ns) that is none.
        """
        held = channel.points
        if not held or channel.waiting is not None or any(point.reasons for point in held):
            return None
        if channel.sequence.contested:
            return None
        times = np.append(np.array([point.time_ns for point in held]), arrivals.time_ns)
        values = np.append(np.array([point.value for point in held]), arrivals.value)
        ordered = bool(np.all(np.diff(times) > 0))
        believed = bool(np.all(np.abs(arrivals.value) <= limits[0]))
        told = bool(np.all((arrivals.quality == 0) | (arrivals.quality == Quality.GOOD)))
        if not (ordered and believed and told and abs(int(times[-1])) <= FARTHEST_NS):
            return None
        if int(arrivals.time_ns[0]) == channel.repeats.heard.time_ns:
            return None
        kept, heard = channel.repeats.look(arrivals.time_ns, arrivals.value)
        last_and_kept = np.append(np.zeros(len(held), np.bool_), kept)
        last_and_kept[len(held) - 1] = True
        if not kept.any() or not channel.reach.surely(times[last_and_kept], values[last_and_kept]):
            return None
        looked = channel.leaps.look(values[last_and_kept])
        if looked is None:
            return None
        kept[kept] = ~looked.strays
        points = np.append(np.ones(len(held), np.bool_), kept)
        times, values = times[points], values[points]
        if np.any(np.diff(times) > limits[1]):
            return None
        numbered = bool(arrivals.numbered.any())
        if numbered and not _in_sequence(channel, arrivals):
            return None
        last = int(arrivals.sequence[-1]) if numbered else None
        apart = channel.clock.look(arrivals.time_ns, channel.sequence.due is not None) if numbered else None
        if numbered and apart is None:
            return None
        strays, told_ns = int(looked.strays.sum()), int(arrivals.time_ns[-1])
        return Track(channel, times, values, kept, strays, heard, looked.changes, last, told_ns, apart)

    def at(self, time_ns: Integers) -> Floats:
        """The values at times between its first and last, by the intake's own arithmetic."""
        before = np.searchsorted(self.times, time_ns, side="right") - 1
        after = np.minimum(before + 1, len(self.times) - 1)
        gap = np.maximum(self.times[after] - self.times[before], 1)
        share = (time_ns - self.times[before]) / gap
        between = self.values[before] + share * (self.values[after] - self.values[before])
        return np.where(self.times[before] == time_ns, self.values[before], between)

    def hand_back(self, last_ns: int) -> None:
        """Leave the channel as after these samples one by one, the last tick being at `last_ns`."""
        first = max(0, int(np.searchsorted(self.times, last_ns, side="right")) - 1)
        kept = zip(self.times[first:].tolist(), self.values[first:].tolist(), strict=True)
        self.channel.pace_ns = int(self.times[-1] - self.times[-2])
        self.channel.points = [Point(time_ns, value, 0) for time_ns, value in kept]
        self.channel.repeats.heard = self.heard
        self.channel.leaps.note_all(self.changes)
        self.channel.counts.received += len(self.kept)
        self.channel.counts.strays += self.strays
        self.channel.counts.accepted += len(self.kept) - self.strays
        clock = self.channel.clock
        clock.forget()
        clock.told_ns = None
        if self.sequence is not None and self.apart is not None:
            self.channel.sequence.pass_over(self.sequence, len(self.kept))
            clock.told_ns, clock.apart = self.told_ns, self.apart


def _in_sequence(channel: Channel, arrivals: Arrivals) -> bool:
    first = int(arrivals.sequence[0])
    expected = channel.sequence.due
    follows = bool(np.all(np.diff(arrivals.sequence) == 1))
    return follows and bool(arrivals.numbered.all()) and expected in (None, first)


class Stretch(NamedTuple):
    """Samples of both channels in the best of order."""

    torque: Track
    speed: Track

    @staticmethod
    def of(intake: Intake, arrivals: Arrivals) -> "Stretch | None":
        """Both tracks; None where the samples must be looked at one by one."""
        if not intake.is_laid:
            return None
        apart = []
        for topic, own in ((SURFACE_TORQUE, ~arrivals.is_speed), (SURFACE_SPEED, arrivals.is_speed)):
            channel = intake.channels[topic]
            its = Arrivals._make(column[own] for column in arrivals)
            track = Track.of(channel, its, (channel.limit, intake.max_gap_ns)) if own.any() else None
            if track is None:
                return None
            apart.append(track)
        stretch = Stretch(*apart)
        return stretch if stretch._abreast(arrivals, intake.max_gap_ns) else None

    def _abreast(self, arrivals: Arrivals, most_ns: int) -> bool:
        """Whether, at each arrival, neither channel has gone on without the other."""
        newest = []
        for track, own in ((self.torque, ~arrivals.is_speed), (self.speed, arrivals.is_speed)):
            believed = own.copy()
            believed[own] = track.kept
            newest.append(track.times[np.cumsum(believed) - believed.sum() - 1])
        return bool(np.all(np.abs(newest[0] - newest[1]) <= most_ns))

    def lay(self, intake: Intake) -> Inputs:
        """The ticks that both channels reach, and the intake left as if it had taken the samples itself."""
        reached = min(int(self.torque.times[-1]), int(self.speed.times[-1]))
        time_ns = intake.ticks_until(reached)
        count = len(time_ns)
        ticks = Inputs(
            intake.pass_over(time_ns) + np.arange(count),
            time_ns,
            self.torque.at(time_ns),
            self.speed.at(time_ns),
            np.zeros(count, np.uint32),
            intake.depths.off_bottom_at(time_ns),
            np.zeros(count),
            np.full(count, intake.forecast_shed),
        )
        if count and (longer_by := intake.depths.longer_by()):
            ticks.longer_by[0], ticks.reasons[0] = longer_by, Reason.STRING_CHANGED
        begun_ns, ended_ns = intake.hole
        ticks.reasons[(time_ns > begun_ns) & (time_ns < ended_ns)] |= np.uint32(Reason.GAP_BRIDGED)
        ticks.reasons[:] |= intake.frozen.flags(ticks.motor_torque, ticks.motor_speed)
        for track in (self.torque, self.speed):
            track.hand_back(int(time_ns[-1]) if count else int(track.times[0]))
        intake.let_go()
        return ticks
