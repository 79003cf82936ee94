"""A session's surface samples in order, each with its place in time, once or over and over."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from vsensor.errors import InputError
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.recording.reader import Session

_SLACK_NS = 1_000_000_000
"""How much further apart two samples' own times may lie than their arrivals: beyond, a stamp is wrong."""

_MAX_TIME_NS = (1 << 63) - 1
_SEQUENCES = 1 << 64


class Placed(NamedTuple):
    """A sample, and when it is due: ns from the session's first sample, laps added up."""

    position_ns: int
    topic: str
    sample: Sample


@dataclass(slots=True)
class _Range:
    first: int
    last: int

    @property
    def span(self) -> int:
        return max(self.last - self.first, 0)


@dataclass(slots=True)
class _Lap:
    """What one lap covers."""

    positions: _Range = field(default_factory=lambda: _Range(0, 0))
    times: _Range = field(default_factory=lambda: _Range(0, 0))
    sequences: dict[str, _Range] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)

    def note(self, position_ns: int, topic: str, sample: Sample) -> None:
        if not self.counts:
            self.positions = _Range(position_ns, position_ns)
            self.times = _Range(sample.time_ns, sample.time_ns)
        self.positions.last = position_ns
        self.times.last = sample.time_ns
        self.counts[topic] = self.counts.get(topic, 0) + 1
        self.sequences.setdefault(topic, _Range(sample.sequence, sample.sequence)).last = sample.sequence

    @property
    def step_ns(self) -> int:
        """The usual time from one sample of a channel to the next; a second where there is but one."""
        steps = max(self.counts.values()) - 1
        return max(round(self.positions.span / steps), 1) if steps else 1_000_000_000


@dataclass(slots=True)
class _Shift:
    """How far the present lap lies behind the first."""

    position_ns: int = 0
    time_ns: int = 0
    sequence: dict[str, int] = field(default_factory=dict)

    def moved(self, position_ns: int, topic: str, sample: Sample) -> Placed:
        sample.time_ns = min(sample.time_ns + self.time_ns, _MAX_TIME_NS)
        if sample.HasField("sequence"):
            sample.sequence = (sample.sequence + self.sequence.get(topic, 0)) % _SEQUENCES
        return Placed(position_ns + self.position_ns, topic, sample)

    def add(self, lap: _Lap) -> None:
        self.position_ns += lap.positions.span + lap.step_ns
        self.time_ns += lap.times.span + lap.step_ns
        for topic, sequence in lap.sequences.items():
            self.sequence[topic] = self.sequence.get(topic, 0) + sequence.span + 1


def laps(
    session: Session, start_s: float, duration_s: float, loop: bool, first_time_ns: int | None
) -> Iterator[Placed]:
    """Yield the surface samples between start and start + duration; again and again with `loop`.

    In a later lap positions, time stamps and sequence numbers run on, one usual step after the last.
    `first_time_ns`, if given, becomes the first time stamp, and all others move with it. Raises
    InputError where nothing lies between.
    """
    shift = _Shift()
    restamped = first_time_ns is None
    while True:
        lap = _Lap()
        for placed in _between(session, start_s, duration_s):
            lap.note(*placed)
            if first_time_ns is not None and not restamped:
                shift.time_ns = first_time_ns - placed.sample.time_ns
                restamped = True
            yield shift.moved(*placed)
        if not lap.counts:
            raise InputError(
                f"{session.path}: holds no {SURFACE_TORQUE} and no {SURFACE_SPEED} "
                f"between {start_s:g} s and {start_s + duration_s:g} s of its time"
            )
        if not loop:
            return
        shift.add(lap)


def _between(session: Session, start_s: float, duration_s: float) -> Iterator[Placed]:
    end_ns = (start_s + duration_s) * 1e9
    for placed in _placed(session):
        if placed.position_ns >= end_ns:
            return
        if placed.position_ns >= start_s * 1e9:
            yield placed


def _placed(session: Session) -> Iterator[Placed]:
    """A sample's place is its own time after the first one's, but for steps that its arrival belies.

    Steps between neighbours add up to that without error, and one wrong stamp among them (a source
    whose clock was set, a bit that flipped) does not hold the player up for years.
    """
    position_ns = 0
    last: tuple[int, int] | None = None
    for topic, message, arrival_ns, _ in session.messages((SURFACE_TORQUE, SURFACE_SPEED)):
        if not isinstance(message, Sample):
            continue
        if last is not None:
            step_ns, arrival_step_ns = message.time_ns - last[0], abs(arrival_ns - last[1])
            believable = abs(step_ns) <= arrival_step_ns + _SLACK_NS
            position_ns += step_ns if believable else arrival_step_ns
        last = message.time_ns, arrival_ns
        yield Placed(position_ns, topic, message)
