"""A course run once or over and over, from wherever the listener wants it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from vsensor.errors import InputError
from vsensor.grid import NS
from vsensor.messages import Message, Sample
from vsensor.recording.course import Course, Placed

_MAX_TIME_NS = (1 << 63) - 1
_SEQUENCES = 1 << 64


@dataclass(slots=True)
class _Range:
    first: int
    last: int

    @property
    def span(self) -> int:
        return max(self.last - self.first, 0)


@dataclass(slots=True)
class _Lap:
    """What one lap has covered."""

    positions: _Range = field(default_factory=lambda: _Range(0, 0))
    times: _Range = field(default_factory=lambda: _Range(0, 0))
    sequences: dict[str, _Range] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)

    def note(self, position_ns: int, topic: str, message: Message) -> None:
        if not self.counts:
            self.positions = _Range(position_ns, position_ns)
            self.times = _Range(message.time_ns, message.time_ns)
        if position_ns >= self.positions.last:  # not where it was sought back to: that is counted
            self.counts[topic] = self.counts.get(topic, 0) + 1
        self.positions.last = position_ns
        self.times.last = message.time_ns
        if isinstance(message, Sample):
            self.sequences.setdefault(
                topic, _Range(message.sequence, message.sequence)
            ).last = message.sequence

    @property
    def step_ns(self) -> int:
        """The usual time from one message of a topic to the next; a second where there is but one."""
        steps = max(self.counts.values()) - 1
        return max(round(self.positions.span / steps), 1) if steps else NS


@dataclass(slots=True)
class _Shift:
    """How far the present lap lies behind the first."""

    position_ns: int = 0
    time_ns: int = 0
    sequence: dict[str, int] = field(default_factory=dict)

    def moved(self, position_ns: int, topic: str, message: Message) -> Placed:
        if self.time_ns:
            for described, _ in message.ListFields():
                if described.name.endswith("time_ns"):
                    moved_ns = min(getattr(message, described.name) + self.time_ns, _MAX_TIME_NS)
                    setattr(message, described.name, moved_ns)
        if isinstance(message, Sample) and message.HasField("sequence"):
            message.sequence = (message.sequence + self.sequence.get(topic, 0)) % _SEQUENCES
        return Placed(position_ns + self.position_ns, topic, message)

    def add(self, lap: _Lap) -> None:
        self.position_ns += lap.positions.span + lap.step_ns
        self.time_ns += lap.times.span + lap.step_ns
        for topic, sequence in lap.sequences.items():
            self.sequence[topic] = self.sequence.get(topic, 0) + sequence.span + 1


class Laps:
    """The messages between start and end; again and again with `loop`.

    In a later lap positions, time stamps and sequence numbers run on, one usual step after the last. `stamp`,
    if given, is asked for the first message's time stamp, and for that after each seek; the others move with
    it. Iterating raises InputError where nothing lies between.
    """

    def __init__(
        self,
        course: Course,
        start_s: float,
        end_s: float,
        loop: bool,
        stamp: Callable[[], int] | None,
    ) -> None:
        self.number = 1
        """Of the lap that is run."""
        self._course = course
        self._start_ns = start_s * NS
        self._end_ns = end_s * NS
        self._loop = loop
        self._stamp = stamp
        self._shift = _Shift()
        self._sought_ns: float | None = None

    def seek(self, position_ns: float) -> float:
        """Go on from another position of the present lap, the nearest that there is; returns it."""
        shift_ns = self._shift.position_ns
        last_ns = min(self._end_ns, self._course.length_ns)
        self._sought_ns = min(max(position_ns - shift_ns, self._start_ns), last_ns)
        return self._sought_ns + shift_ns

    def on_course(self, position_ns: float) -> float:
        """Where a position of the present lap lies on the course."""
        return position_ns - self._shift.position_ns

    def __iter__(self) -> Iterator[Placed]:
        """Yield each message when it is asked for; what comes next may be sought meanwhile."""
        while True:
            lap = _Lap()
            yield from self._lap(lap)
            if not lap.counts:
                raise InputError(self._nothing())
            if not self._loop:
                return
            self._shift.add(lap)
            self.number += 1

    def _lap(self, lap: _Lap) -> Iterator[Placed]:
        begin_ns: float | None = self._start_ns
        stamp, sought = None if self._shift.position_ns else self._stamp, False
        while begin_ns is not None:
            for placed in self._course.between(begin_ns, self._end_ns):
                lap.note(*placed)
                if stamp is not None:
                    wait_ns = round(placed.position_ns - begin_ns) if sought else 0
                    self._shift.time_ns = stamp() + wait_ns - placed.message.time_ns
                    stamp = None
                yield self._shift.moved(*placed)
                if self._sought_ns is not None:
                    break
            begin_ns, self._sought_ns = self._sought_ns, None
            stamp, sought = self._stamp, True

    def _nothing(self) -> str:
        sessions = ", ".join(str(leg.session.path) for leg in self._course.legs)
        length_ns = self._course.length_ns
        end = f"its end at {length_ns / NS:g} s" if self._end_ns > length_ns else f"{self._end_ns / NS:g} s"
        topics = ", ".join(self._course.topics)
        return f"{sessions}: holds none of {topics} between {self._start_ns / NS:g} s and {end}"
