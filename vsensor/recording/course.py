"""Sessions laid one after the other on one line of time, readable from any place of it."""

import math
from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

from vsensor.errors import InputError
from vsensor.grid import NS
from vsensor.messages import SURFACE_TOPICS, Message, Sample
from vsensor.recording.reader import Record, Session

_SLACK_NS = NS
"""How much further apart two samples' own times may lie than their arrivals: beyond, a stamp is wrong."""


class Placed(NamedTuple):
    """A message, and when it is due: ns from the first."""

    position_ns: int
    topic: str
    message: Message


class Leg(NamedTuple):
    """One session's place on the line."""

    session: Session
    first: Record
    position_ns: int
    """Of its first message."""
    end_ns: int
    """Of its last, by arrival."""
    gap_s: float
    """From the last message of the session before to the first of this one, as recorded."""


class Course:
    """The messages of these topics; gaps between sessions as they were, but no longer than `longest_gap_s`.

    Sessions without one are passed over, as parts of a recording during which no samples came. Raises
    InputError where none of them holds any.
    """

    def __init__(
        self,
        sessions: Sequence[Session],
        topics: Collection[str] = SURFACE_TOPICS,
        longest_gap_s: float = math.inf,
    ) -> None:
        self.topics = topics
        self.legs: list[Leg] = []
        self.passed_over: list[Session] = []
        for session in sessions:
            first = next(session.messages(topics), None)
            if first is None:
                self.passed_over.append(session)
            else:
                self.legs.append(self._leg(session, first, longest_gap_s))
        if not self.legs:
            paths = ", ".join(str(session.path) for session in sessions)
            raise InputError(f"{paths}: holds none of {', '.join(topics)}")

    @property
    def length_ns(self) -> int:
        """Where the last message lies, by arrival."""
        return self.legs[-1].end_ns

    def leg(self, position_ns: float) -> Leg:
        """The session to which a position belongs."""
        begun = [leg for leg in self.legs if leg.position_ns <= position_ns]
        return begun[-1] if begun else self.legs[0]

    def between(self, start_ns: float, end_ns: float) -> Iterator[Placed]:
        """Yield what lies there, in the order of the files."""
        for at, leg in enumerate(self.legs):
            if leg.position_ns >= end_ns:
                return
            following = self.legs[at + 1].position_ns if at + 1 < len(self.legs) else math.inf
            if following <= start_ns:
                continue
            for placed in _placed(leg, self.topics, start_ns):
                if placed.position_ns >= end_ns:
                    return
                if placed.position_ns >= start_ns:
                    yield placed

    def _leg(self, session: Session, first: Record, longest_gap_s: float) -> Leg:
        wanted = [topic for topic in session.summary().topics if topic.topic in self.topics]
        if not wanted:  # a bit of its index has flipped
            raise InputError(
                f"{session.path}: holds messages of which the index at its end knows nothing: "
                f"have it written anew by vsensor recover {session.path}"
            )
        span_ns = max(max(topic.last_ns for topic in wanted) - first.log_time_ns, 0)
        if not self.legs:
            return Leg(session, first, 0, span_ns, 0.0)
        before = self.legs[-1]
        ended_ns = before.first.log_time_ns + before.end_ns - before.position_ns
        gap_s = (first.log_time_ns - ended_ns) / NS
        begins_ns = before.end_ns + round(min(max(gap_s, 0.0), longest_gap_s) * NS) + 1
        return Leg(session, first, begins_ns, begins_ns + span_ns, gap_s)


def _placed(leg: Leg, topics: Collection[str], start_ns: float) -> Iterator[Placed]:
    """A surface sample's place is its own time after the first one's, but for steps that its arrival belies.

    Steps between neighbours add up to that without error, and one wrong stamp among them (a source
    whose clock was set, a bit that flipped) does not hold the player up for years. Other messages are
    placed by their arrival after the sample before.
    """
    position_ns = leg.position_ns
    last = _own_ns(leg.first), leg.first.log_time_ns
    since_ns = leg.first.log_time_ns + int(start_ns) - leg.position_ns - 2 * _SLACK_NS if start_ns > 0 else 0
    for record in leg.session.messages(topics, max(since_ns, 0)):
        arrival_step_ns = record.log_time_ns - last[1]
        if record.topic not in SURFACE_TOPICS:
            yield Placed(position_ns + arrival_step_ns, record.topic, record.message)
            continue
        step_ns = _own_ns(record) - last[0]
        believable = abs(step_ns) <= abs(arrival_step_ns) + _SLACK_NS
        position_ns += step_ns if believable else abs(arrival_step_ns)
        last = _own_ns(record), record.log_time_ns
        yield Placed(position_ns, record.topic, record.message)


def _own_ns(record: Record) -> int:
    """A surface sample's own time; of other messages their arrival."""
    sample = record.topic in SURFACE_TOPICS and isinstance(record.message, Sample)
    return record.message.time_ns if sample else record.log_time_ns
