"""What a session holds, told without decoding it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import MessageIndex

from vsensor.errors import InputError
from vsensor.recording.damage import Holes
from vsensor.recording.index import Index
from vsensor.recording.scan import Scan
from vsensor.recording.whole import Content, WholeReads
from vsensor.recording.writer import COULD_NOT_BE_READ


@dataclass(frozen=True, slots=True)
class TopicSummary:
    """One topic: how many messages, and when the first and the last came (log time, ns)."""

    topic: str
    messages: int
    first_ns: int
    last_ns: int

    @property
    def rate_hz(self) -> float:
        """Messages a second between the first and the last; 0 for fewer than two."""
        span = (self.last_ns - self.first_ns) / 1e9
        return (self.messages - 1) / span if span > 0 else 0.0


@dataclass(frozen=True, slots=True)
class Summary:
    """A session as a whole; `dropped` is None where its recorder could not say."""

    path: Path
    complete: bool
    size_bytes: int
    holes: Holes
    """Where it could not be read, as far as it was."""
    rig: str
    topics: tuple[TopicSummary, ...]
    dropped: int | None
    metadata: Mapping[str, str]
    recorder: Mapping[str, str]

    @property
    def lost(self) -> str:
        """What could not be read of the session of which this one was recovered, in words."""
        return self.metadata.get(COULD_NOT_BE_READ, "")

    @property
    def messages(self) -> int:
        """All messages together."""
        return sum(topic.messages for topic in self.topics)

    @property
    def first_ns(self) -> int:
        """When the first message came; 0 where there is none."""
        return min((topic.first_ns for topic in self.topics), default=0)

    @property
    def duration_s(self) -> float:
        """From the first message to the last."""
        return (max((topic.last_ns for topic in self.topics), default=0) - self.first_ns) / 1e9


def summarise(
    path: Path,
    index: Index | None,
    complete: bool,
    holes: Holes,
    metadata: Mapping[str, str],
    recorder: Mapping[str, str],
) -> Summary:
    """Sum a session up: from its index if it has one, else by reading it through."""
    try:
        topics = _from_index(path, index)
    except Exception:  # no index, or not a sound one: what it says cannot be followed
        topics, holes = _from_scan(path)
    return Summary(
        path=path,
        complete=complete,
        size_bytes=path.stat().st_size,
        holes=holes,
        rig=metadata.get("rig", ""),
        topics=tuple(sorted(topics, key=lambda topic: topic.topic)),
        dropped=_dropped(recorder),
        metadata=metadata,
        recorder=recorder,
    )


def _dropped(recorder: Mapping[str, str]) -> int | None:
    counts = [recorder.get(f"dropped_by_{who}", "") for who in ("daemon", "recorder")]
    return sum(int(count) for count in counts) if all(count.isdecimal() for count in counts) else None


def _from_index(path: Path, index: Index | None) -> list[TopicSummary]:
    if index is None or index.statistics is None:
        raise InputError(f"{path}: has no index")
    found = []
    with WholeReads(path) as file:
        for channel in index.channels.values():
            if count := index.statistics.channel_message_counts.get(channel.id, 0):
                first = _times(file, index.first[channel.id])[0]
                last = _times(file, index.last[channel.id])[-1]
                found.append(TopicSummary(channel.topic, count, first, last))
    return found


def _times(file: WholeReads, place: int) -> list[int]:
    file.seek(place)
    opcode, content = file.record()
    is_index = opcode == Opcode.MESSAGE_INDEX
    return [time for time, _ in MessageIndex.read(Content(content)).records] if is_index else []


def _from_scan(path: Path) -> tuple[list[TopicSummary], Holes]:
    found: dict[str, TopicSummary] = {}
    scan = Scan(path, through=True)
    for _, channel, message in scan.messages():
        known = found.get(channel.topic) or TopicSummary(channel.topic, 0, message.log_time, 0)
        found[channel.topic] = replace(known, messages=known.messages + 1, last_ns=message.log_time)
    return list(found.values()), scan.holes
