"""A session read by columns: of each topic the fields asked for, as arrays, and no Python per message."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import DecodeError
from mcap.records import Channel, Schema

from vsensor.errors import InputError
from vsensor.messages import Message
from vsensor.recording.blocks import Block, blocks
from vsensor.recording.layout import (
    CHANNEL,
    COUNT,
    EIGHT,
    END,
    FIRST,
    FOUR,
    LIST,
    LOG_TIME,
    PUBLISH_TIME,
    START,
    VARINT,
    Bytes,
    Places,
    Words,
    find_fields,
    gather_doubles,
)
from vsensor.recording.reader import Session

LARGEST = 1 << 24
"""Numbers in the lists of a block, all filled up to the longest: one long among many short is no profile."""

Values = npt.NDArray[Any]
Known = npt.NDArray[np.bool_]

_SCALARS: Mapping[int, tuple[int, type[np.generic]]] = {
    FieldDescriptor.TYPE_DOUBLE: (EIGHT, np.float64),
    FieldDescriptor.TYPE_SFIXED64: (EIGHT, np.int64),
    FieldDescriptor.TYPE_FIXED64: (EIGHT, np.uint64),
    FieldDescriptor.TYPE_FIXED32: (FOUR, np.uint32),
    FieldDescriptor.TYPE_BOOL: (VARINT, np.bool_),
    FieldDescriptor.TYPE_ENUM: (VARINT, np.int32),
}


@dataclass(frozen=True, slots=True)
class Columns:
    """n messages of one topic."""

    place: Places
    """Which message of the session each is, counted over all topics; shape (n,)."""
    log_time_ns: Places
    publish_time_ns: Places
    values: Mapping[str, Values]
    """Each field's values in its own type, 0 where it is not set; shape (n,). Of a list of doubles shape
    (n, most), NaN behind its end."""
    known: Mapping[str, Known]
    """Whether each field is set; shape (n,)."""
    messages: Sequence[Message] = ()
    """The messages themselves, where they are read whole."""

    def __len__(self) -> int:
        return len(self.place)

    def number(self, field: str) -> npt.NDArray[np.float64]:
        """A field as doubles, NaN where it is not set."""
        return np.where(self.known[field], self.values[field], np.nan)


def read_columns(
    session: Session, wanted: Mapping[str, Collection[str]], whole: Collection[str] = ()
) -> Iterator[Mapping[str, Columns]]:
    """Yield of each topic of `wanted` the fields named there, some megabytes of the file at a time.

    Topics of `whole` are read as messages, one by one: those that are few. A topic that has no message in a
    piece is absent from it. Raises InputError as `Session.messages` does;
    ValueError for a field that is neither a number nor a list of doubles.
    """
    scan = session.scan()
    schemas: dict[int, Schema] = {}
    readers: dict[int, _Reader] = {}
    for record in blocks(scan):
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            kind = session.kind(schemas.get(record.schema_id), record)
            if kind is None or record.id in readers:
                continue
            if record.topic in wanted or record.topic in whole:
                readers[record.id] = _Reader(session, record.topic, kind, wanted.get(record.topic))
        else:
            read = {reader.topic: reader.read(record, scan.count, id_) for id_, reader in readers.items()}
            scan.count += len(record.messages)
            yield {topic: columns for topic, columns in read.items() if len(columns)}
    session.account(scan)


class _Reader:
    """Reads one channel's messages from blocks."""

    def __init__(
        self, session: Session, topic: str, kind: type[Message], fields: Collection[str] | None
    ) -> None:
        self.topic = topic
        self._session = session
        self._kind = kind
        self._whole = fields is None
        self._fields = [kind.DESCRIPTOR.fields_by_name[name] for name in fields or ()]
        self._before = 0
        highest = max((field.number for field in self._fields), default=0)
        self._wanted = np.full(highest + 1, -1)
        self._slots = np.zeros(highest + 1, np.int64)
        self._columns = 0
        for field in self._fields:
            self._wanted[field.number] = wire = _wire_type(field)
            self._slots[field.number] = self._columns
            self._columns += 2 if wire == LIST else 1
        self._out = np.empty((0, self._columns), np.uint64)
        self._set = np.empty((0, self._columns), np.bool_)

    def read(self, block: Block, before: int, channel: int) -> Columns:
        """This channel's messages of a block before which the session has so many."""
        place = np.flatnonzero(block.messages[:, CHANNEL] == channel)
        own = block.messages[place]
        columns = self._messages(block.data, own) if self._whole else self._values(block.data, own)
        self._before += len(own)
        return Columns(before + place, own[:, LOG_TIME], own[:, PUBLISH_TIME], *columns)

    def _messages(
        self, data: Bytes, own: Places
    ) -> tuple[Mapping[str, Values], Mapping[str, Known], Sequence[Message]]:
        return {}, {}, [self._decoded(data, own, row) for row in range(len(own))]

    def _values(self, data: Bytes, own: Places) -> tuple[Mapping[str, Values], Mapping[str, Known]]:
        out, set_ = self._room(len(own))
        unusual = np.zeros(len(own), np.bool_)
        find_fields(data, own[:, START], own[:, END], self._wanted, self._slots, out.T, set_.T, unusual)
        others = {row: self._decoded(data, own, row) for row in np.flatnonzero(unusual).tolist()}
        values, known = {}, {}
        for field in self._fields:
            slot = self._slots[field.number]
            known[field.name] = set_[:, slot].copy()
            values[field.name] = (
                _lists(data, out[:, slot:], field, others)
                if field.is_repeated
                else _numbers(out[:, slot], known[field.name], field, others)
            )
        return values, known

    def _room(self, rows: int) -> tuple[Words, Known]:
        """Zeros to be filled, in the same place each time: new room would cost as much again."""
        if rows > len(self._out):
            self._out = np.empty((rows, self._columns), np.uint64)
            self._set = np.empty((rows, self._columns), np.bool_)
        out, set_ = self._out[:rows], self._set[:rows]
        out[:], set_[:] = 0, False
        return out, set_

    def _decoded(self, data: Bytes, own: Places, row: int) -> Message:
        """A message by the general reader."""
        try:
            return self._kind.FromString(data[own[row, START] : own[row, END]].tobytes())
        except DecodeError as error:
            raise InputError(
                f"{self._session.path}: {self.topic}, message {self._before + row + 1}: "
                f"cannot be decoded as {self._kind.DESCRIPTOR.full_name}: {error}"
            ) from error


def _wire_type(field: FieldDescriptor) -> int:
    if field.is_repeated and field.type == FieldDescriptor.TYPE_DOUBLE:
        return LIST
    if field.is_repeated or field.type not in _SCALARS:
        raise ValueError(f"{field.full_name} is neither a number nor a list of doubles")
    return _SCALARS[field.type][0]


def _numbers(
    words: npt.NDArray[np.uint64], known: Known, field: FieldDescriptor, others: Mapping[int, Message]
) -> Values:
    wire, kind = _SCALARS[field.type]
    # A copy in any case: a message's fields lie side by side in `words`, a column's values shall too.
    values = np.ascontiguousarray(words).view(kind) if wire == EIGHT else words.astype(kind)
    for row, message in others.items():
        known[row] = message.HasField(field.name)  # type: ignore[arg-type]
        values[row] = getattr(message, field.name)
    return values


def _lists(
    data: Bytes, words: npt.NDArray[np.uint64], field: FieldDescriptor, others: Mapping[int, Message]
) -> Values:
    for row in others:
        words[row, COUNT] = 0
    general = {row: list(getattr(message, field.name)) for row, message in others.items()}
    most = max([int(words[:, COUNT].max(initial=0)), *map(len, general.values())])
    if len(words) * most > LARGEST:
        raise InputError(f"{field.full_name}: lists of up to {most} numbers in {len(words)} messages at once")
    values = np.full((len(words), most), np.nan)
    gather_doubles(data, words[:, FIRST], words[:, COUNT], values.view(np.uint64))
    for row, doubles in general.items():
        values[row, : len(doubles)] = doubles
    return values
