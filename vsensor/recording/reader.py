"""Sessions read back: whole ones, and torn ones as far as they go."""

from collections.abc import Collection, Iterable, Iterator
from itertools import takewhile
from pathlib import Path
from typing import NamedTuple

from google.protobuf.message import DecodeError
from mcap.records import Attachment, Channel, McapRecord, Metadata, Schema
from mcap.records import Message as McapMessage
from mcap.well_known import MessageEncoding

from vsensor.errors import InputError
from vsensor.messages import SENSOR_STATE, SENSOR_TICK, SURFACE_TOPICS, Message, State, message_type
from vsensor.recording.damage import Holes
from vsensor.recording.index import Index, read_index
from vsensor.recording.scan import Scan
from vsensor.recording.summary import Summary, summarise
from vsensor.recording.whole import WholeReads
from vsensor.recording.writer import (
    CONFIGURATION,
    COULD_NOT_BE_READ,
    METADATA,
    RECORDER,
    RECOVERED_FROM,
)

_MAGIC = b"\x89MCAP0\r\n"
_EXPECTED = "a session written by vsensor (NAME.mcap, or NAME.mcap.part where it was torn) was expected"


class Record(NamedTuple):
    """One message of a session."""

    topic: str
    message: Message
    log_time_ns: int
    publish_time_ns: int


class Session:
    """A session's file. Raises InputError, which says what the file is, where it is none.

    `complete` is False for a torn file: its messages end at the tear. `configuration` is the text
    attached at its start, `metadata` what was noted there, `recorder` what was noted at its end.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        _check_is_mcap(path)
        self.complete, self.index, self.holes, found = _open(path)
        """Its end, where it has one; and where it could not be read, as far as it has been."""
        attached = [r for r in found if isinstance(r, Attachment) and r.name == CONFIGURATION]
        notes = {r.name: r.metadata for r in found if isinstance(r, Metadata)}
        self.configuration = attached[0].data.decode(errors="replace") if attached else None
        self.metadata = notes.get(METADATA, {})
        self.recorder = notes.get(RECORDER, {})
        self._check_is_ours(found)

    def messages(self, topics: Collection[str] | None = None, since_ns: int = 0) -> Iterator[Record]:
        """Yield the messages of these topics (of all, by default) in the file's order.

        That is the order of arrival, which makes a run over them exact. Topics that we do not know
        are passed over, and what was received before `since_ns`, of which an index spares the reading.
        Raises InputError for a message that cannot be decoded, and for damage within a complete file.
        """
        scan = self.scan()
        kinds: dict[str, type[Message] | None] = {}
        numbers: dict[str, int] = {}
        for schema, channel, message in scan.messages(since_ns, self.index):
            topic = channel.topic
            if message.log_time < since_ns or (topics is not None and topic not in topics):
                continue
            if topic not in kinds:
                kinds[topic] = self.kind(schema, channel)
            kind = kinds[topic]
            if kind is None:
                continue
            numbers[topic] = numbers.get(topic, 0) + 1
            try:
                decoded = kind.FromString(message.data)
            except DecodeError as error:
                raise InputError(
                    f"{self.path}: {topic}, message {numbers[topic]}: "
                    f"cannot be decoded as {kind.DESCRIPTOR.full_name}: {error}"
                ) from error
            yield Record(topic, decoded, message.log_time, message.publish_time)
        if not since_ns:
            self.account(scan)

    def state(self) -> State | None:
        """What the recording sensor remembered at the start; None where the session does not tell."""
        first = next(self.messages((SENSOR_STATE, SENSOR_TICK, *SURFACE_TOPICS)), None)
        return first.message if first is not None and isinstance(first.message, State) else None

    def summary(self) -> Summary:
        """What is in it; instant for a complete session, one reading of the file for a torn one."""
        return summarise(self.path, self.index, self.complete, self.holes, self.metadata, self.recorder)

    def shortfall(self) -> str:
        """In words, why what can be read of it is not all; nothing of a whole one."""
        lost = f"{self.holes.words()} cannot be read" if self.holes else ""
        said = []
        if not self.complete:
            said.append(f"is torn, damaged or still being written{lost and f': {lost}'}")
        elif lost:
            said.append(f"is damaged: {lost}")
        if COULD_NOT_BE_READ in self.metadata:
            origin = self.metadata.get(RECOVERED_FROM, "another")
            said.append(
                f"was recovered from {origin}, of which {self.metadata[COULD_NOT_BE_READ]} could not be read"
            )
        return "; it ".join(said)

    def lacks(self, what: str) -> InputError:
        """The error that something is missing in it, which names the damage that may have taken it."""
        shortfall = self.shortfall()
        return InputError(
            f"{self.path}: {shortfall}; what is left of it {what}" if shortfall else f"{self.path}: {what}"
        )

    def scan(self) -> Scan:
        """A reading of it: of a complete one up to damage, of a torn one past it."""
        return Scan(self.path, through=not self.complete)

    def account(self, scan: Scan) -> None:
        """Note what a reading to the end could not read; InputError where a complete session misses anything.

        A damaged length makes it pass over what follows, so the index's count is asked too.
        """
        if not self.complete:
            self.holes = scan.holes
            return
        counted = self.index.statistics.message_count if self.index and self.index.statistics else scan.count
        if scan.finished and scan.count == counted:
            return
        raise InputError(
            f"{self.path}: is damaged after byte {scan.whole_bytes}: "
            f"{scan.fault or f'{scan.count} messages of {counted} are found'}; "
            f"what is sound in it can be had by: vsensor recover {self.path}"
        )

    def kind(self, schema: Schema | None, channel: Channel) -> type[Message] | None:
        """The message that a channel of this file holds; None where we know none, InputError for another."""
        kind = message_type(channel.topic)
        if kind is None:
            return None
        expected = kind.DESCRIPTOR.full_name
        if schema is None or schema.name != expected or channel.message_encoding != MessageEncoding.Protobuf:
            raise InputError(
                f"{self.path}: {channel.topic} holds {_described(channel, schema)}, "
                f"where {expected} (protobuf) was expected"
            )
        return kind

    def _check_is_ours(self, found: Iterable[McapRecord]) -> None:
        schemas = {r.id: r for r in found if isinstance(r, Schema)}
        channels = [r for r in found if isinstance(r, Channel)]
        ours = [c for c in channels if self.kind(schemas.get(c.schema_id), c)]
        if ours or self.metadata or not (channels or self.complete):
            return
        held = ", ".join(f"{c.topic} ({_described(c, schemas.get(c.schema_id))})" for c in channels)
        raise InputError(f"{self.path}: is an MCAP file that holds {held or 'no messages'}; {_EXPECTED}")


def _check_is_mcap(path: Path) -> None:
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise InputError(
            f"{path}: is neither file nor folder; {_EXPECTED}"
        )  # a pipe, to be waited at for ever
    try:
        with path.open("rb") as file:
            start = file.read(len(_MAGIC))
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file; {_EXPECTED}") from error
    except IsADirectoryError as error:
        raise InputError(f"{path}: is a folder; {_EXPECTED}") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    if not start:
        raise InputError(f"{path}: is empty (0 bytes); {_EXPECTED}")
    if start != _MAGIC[: len(start)]:
        raise InputError(f"{path}: is no MCAP file (it begins with {start!r}); {_EXPECTED}")


def _open(path: Path) -> tuple[bool, Index | None, Holes, list[McapRecord]]:
    """Whether the file is complete, its index if it has one, what is damaged, and what it says of itself."""
    try:
        with WholeReads(path) as file:
            index = read_index(file)
    except Exception:  # whatever is met in a torn index: the file is not complete
        return False, None, *_before_messages(path)
    if index is None:
        return True, None, *_before_messages(path)
    return True, index, Holes(), [*index.noted, *index.schemas.values(), *index.channels.values()]


def _before_messages(path: Path) -> tuple[Holes, list[McapRecord]]:
    scan = Scan(path, through=True)
    return scan.holes, list(takewhile(lambda record: not isinstance(record, McapMessage), scan.records()))


def _described(channel: Channel, schema: Schema | None) -> str:
    return f"{schema.name if schema else 'no schema'}, {channel.message_encoding}"
