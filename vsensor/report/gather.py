"""A session gathered for the report, in memory that its length adds next to nothing to."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from vsensor.errors import InputError
from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    SENSOR_TICK,
    STRING_PROFILE,
    Event,
    Message,
    Status,
)
from vsensor.quality import Quality
from vsensor.recording.columns import Columns, read_columns
from vsensor.recording.reader import Session
from vsensor.report.along import PROFILE, Along, worst
from vsensor.report.counts import counted
from vsensor.report.figures import Extent, Stands
from vsensor.report.foretold import Counted, Foretold
from vsensor.report.seconds import Seconds
from vsensor.report.thin import Thinned
from vsensor.report.ticks import BIT, BIT_TORQUE, FIELDS, TOP, TOP_TORQUE, Floats, Ticks, ticks_of

MOST_EVENTS = 60
"""So many are told one by one."""
OVER_TIME = (TOP, BIT, TOP_TORQUE, BIT_TORQUE)
"""What is drawn over the whole session."""


@dataclass
class Story:
    """What a session tells, put together tick by tick. Times in ns, all else SI, NaN where not known."""

    ticks: int = 0
    good: int = 0
    """Ticks of good quality."""
    first_ns: int = 0
    """The time of the first tick,"""
    latest_ns: int = 0
    """and the latest of all."""
    extents: dict[str, Extent] = field(default_factory=lambda: {name: Extent() for name in OVER_TIME})
    over_time: Thinned = field(default_factory=lambda: Thinned(len(OVER_TIME)))
    """`OVER_TIME`, each at the time for which its confirmed answer is."""
    seconds: Seconds = field(default_factory=Seconds)
    stands: Stands = field(default_factory=Stands)
    foretold: Foretold = field(default_factory=Foretold)
    counted: Counted = field(default_factory=Counted)
    lateness_s: Extent = field(default_factory=Extent)
    """How late the loop woke for each tick."""
    opening: Status | None = None
    """The first status,"""
    status: Status | None = None
    """and the last one."""
    events: list[Event] = field(default_factory=list)
    """The first ones,"""
    more_events: int = 0
    """and how many came after them."""
    along: Along | None = None

    def add_ticks(self, ticks: Ticks) -> None:
        """Add ticks in the file's order."""
        self.first_ns = self.first_ns if self.ticks else int(ticks.time_ns[0])
        self.latest_ns = int(ticks.time_ns.max(initial=self.latest_ns if self.ticks else self.first_ns))
        self.ticks += len(ticks)
        self.good += int((ticks["quality"] == Quality.GOOD).sum())
        for name, extent in self.extents.items():
            extent.add(ticks[name])
        self.over_time.add(ticks.confirmed_ns, *(ticks[name] for name in OVER_TIME))
        self.seconds.add(ticks)
        self.stands.add(ticks)
        self.foretold.add(ticks)

    def add_profiles(self, profiles: Columns) -> None:
        """Add profiles of the string."""
        came = worst(profiles)
        self.along = came if self.along is None else self.along.take(came)

    def counts(self, begun_ns: int) -> Status | None:
        """What the sensor counted in a session begun at that log time, and its last status else."""
        if self.opening is None or self.status is None:
            return None
        return counted(self.opening, self.status, begun_ns)

    def add_messages(self, messages: Sequence[Message]) -> None:
        """Add statuses and events."""
        for message in messages:
            if isinstance(message, Status):
                self.opening = self.opening or message
                self.status = message
                self.counted.add(message)
            elif isinstance(message, Event) and len(self.events) < MOST_EVENTS:
                self.events.append(message)
            elif isinstance(message, Event):
                self.more_events += 1


def gather(session: Session) -> Story:
    """Read a session once. Raises InputError where it holds no estimates."""
    wanted = {BIT_ESTIMATE: FIELDS, SENSOR_TICK: ("lateness_ns",), STRING_PROFILE: PROFILE}
    story = Story()
    for piece in read_columns(session, wanted, whole=(SENSOR_STATUS, SENSOR_EVENT)):
        if BIT_ESTIMATE in piece:
            story.add_ticks(ticks_of(piece[BIT_ESTIMATE]))
        if SENSOR_TICK in piece:
            story.lateness_s.add(late(piece[SENSOR_TICK]))
        if STRING_PROFILE in piece:
            story.add_profiles(piece[STRING_PROFILE])
        for columns in piece.values():
            story.add_messages(columns.messages)
    if not story.ticks:
        raise InputError(
            f"{session.path}: holds no {BIT_ESTIMATE} to report on; they can be made of its samples by: "
            f"vsensor estimate {session.path} RIG.toml -o WITH_ESTIMATES.mcap"
        )
    return story


def late(ticks: Columns) -> Floats:
    """How late the loop woke for each tick, s, where a loop ran."""
    return ticks.number("lateness_ns") / 1e9
