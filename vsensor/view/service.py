"""How the sensor itself does: lateness, work, age of the input, losses, queues."""

from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

from vsensor.messages import Message, Status, Tick
from vsensor.messages.books import refused
from vsensor.units import factor
from vsensor.view import series, words
from vsensor.view.batches import Batch, Colour, Look, Page, Points
from vsensor.view.palette import BLUE, GREEN, GREY, ORANGE, PINK, VERMILION, WHITE
from vsensor.view.part import Part
from vsensor.view.trace import Trace

_MS_IN_S = factor("s", "ms")
_MS_IN_NS = factor("ns", "ms")


class Counter(NamedTuple):
    """A count in the status of which each one is a loss, and how it is drawn."""

    name: str
    look: tuple[str, Colour]
    count: Callable[[Status], int]


class Queue(NamedTuple):
    """What the status tells of something that waits, and how it is drawn."""

    name: str
    field: Literal["inbox_waiting", "recorder_queue_bytes", "recording_backlog_bytes"]
    look: tuple[str, Colour]
    scale: float


_COUNTERS = (
    Counter("lost", ("samples lost", VERMILION), lambda s: sum(c.lost for c in s.channels)),
    Counter("refused", ("samples refused", ORANGE), lambda s: sum(map(refused, s.channels))),
    Counter("skipped", ("slots skipped", BLUE), lambda s: s.slots_skipped),
    Counter("unrecorded", ("not recorded", PINK), lambda s: s.recorder_dropped),
)
QUEUES = (
    Queue("inbox", "inbox_waiting", ("loop, samples", GREEN), 1.0),
    Queue("recorder", "recorder_queue_bytes", ("recorder, kB", BLUE), 1e-3),
    Queue("disk", "recording_backlog_bytes", ("disk, MB", ORANGE), 1e-6),
)
_LINES = (
    Look(series.EACH_TICK, "each tick", GREEN, 1.5),
    Look(series.P99, "99 % below", VERMILION, 2.0),
    Look(f"{series.WORK}/p50", "median", GREEN, 2.0),
    Look(f"{series.WORK}/p99", "99 % below", VERMILION, 2.0),
    Look(f"{series.AGES}/surface_torque", "torque", ORANGE, 2.0),
    Look(f"{series.AGES}/surface_speed", "speed", BLUE, 2.0),
    Look(f"{series.LOSSES}/unseen", "not seen here", GREY, 2.0),
    Look(f"{series.QUEUES}/view", "view, messages", WHITE, 2.0),
    *(Look(f"{series.QUEUES}/{q.name}", q.look[0], q.look[1], 2.0) for q in QUEUES),
    *(Look(f"{series.LOSSES}/{c.name}", c.look[0], c.look[1], 2.0) for c in _COUNTERS),
)


class Service(Part):
    """The plots and the page of the service tab."""

    def __init__(self) -> None:
        self._lines: defaultdict[str, Trace] = defaultdict(Trace)
        self._out: list[Batch] = list(_LINES)
        self._before: Status | None = None
        self._number: int | None = None
        self._missed = self._missed_before = 0
        self._waited = 0

    def take(self, message: Message) -> None:
        """Take in one message."""
        match message:
            case Tick():
                if self._number is not None and message.number > self._number + 1:
                    self._missed += message.number - self._number - 1
                self._number = message.number
                self._lines[series.EACH_TICK].add(message.time_ns, message.lateness_ns * _MS_IN_NS)
            case Status():
                self._take_status(message, self.at_ns)

    def waited(self, messages: int) -> None:
        """Note how many messages waited when the view looked."""
        self._waited = max(self._waited, messages)

    def batches(self) -> Iterator[Batch]:
        """Hand over what has come since the last call."""
        yield from self._out
        self._out = []
        for entity, trace in self._lines.items():
            times, values = trace.take()
            if times.size:
                yield Points(entity, times, values[:, 0])

    def _take_status(self, status: Status, at_ns: int) -> None:
        self._lines[series.P99].add(at_ns, status.lateness_p99_s * _MS_IN_S)
        self._lines[f"{series.WORK}/p50"].add(at_ns, status.work_p50_s * _MS_IN_S)
        self._lines[f"{series.WORK}/p99"].add(at_ns, status.work_p99_s * _MS_IN_S)
        for channel in status.channels:
            entity = f"{series.AGES}/{channel.channel.replace('/', '_')}"
            if channel.HasField("age_s"):
                self._lines[entity].add(at_ns, channel.age_s * _MS_IN_S)
        self._count_losses(status, at_ns)
        self._lines[f"{series.QUEUES}/view"].add(at_ns, self._waited)
        self._waited = 0
        for queue in QUEUES:
            if status.HasField(queue.field):
                self._lines[f"{series.QUEUES}/{queue.name}"].add(
                    at_ns, getattr(status, queue.field) * queue.scale
                )
        self._out.append(Page(series.HEALTH, at_ns, words.health(status, self._missed)))

    def _count_losses(self, status: Status, at_ns: int) -> None:
        """What was lost since the last status; nothing of a daemon's before, nor of one that began anew."""
        before, self._before = self._before, status
        if before is None or before.uptime_s > status.uptime_s:
            return
        for counter in _COUNTERS:
            lost = counter.count(status) - counter.count(before)
            self._lines[f"{series.LOSSES}/{counter.name}"].add(at_ns, lost)
        self._lines[f"{series.LOSSES}/unseen"].add(at_ns, self._missed - self._missed_before)
        self._missed_before = self._missed
