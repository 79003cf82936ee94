"""A session's messages in blocks: the bytes of some chunks, and where in them each message stands."""

from collections.abc import Iterable, Iterator, Sequence
from io import BytesIO
from typing import NamedTuple

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Schema
from mcap.stream_reader import get_chunk_data_stream

from vsensor.recording.layout import (
    MESSAGE_HEAD,
    RECORD_HEAD,
    Bytes,
    Places,
    find_records,
)
from vsensor.recording.scan import Scan

BLOCK_BYTES = 2 << 20
"""Messages of so many bytes are taken together: of fewer, NumPy's cost of a call would count."""


class Block(NamedTuple):
    """Messages as they stand in the file, in its order."""

    data: Sequence[Bytes]
    """The bytes, those of each chunk apart."""
    messages: Places
    """What `layout` finds of each, shape (n, 5)."""
    ends: Places
    """How many messages there are up to the end of each chunk, shape (chunks,)."""


def blocks(scan: Scan) -> Iterator[Schema | Channel | Block]:
    """Yield a session's schemas and channels, and its messages in blocks: what tells of them comes before."""
    waiting: list[tuple[Bytes, Places]] = []
    size = 0
    for record in scan.unpacked(unpack):
        if isinstance(record, Schema | Channel):
            yield record
        elif isinstance(record, Message | tuple):
            waiting.append(_alone(record) if isinstance(record, Message) else record)
            size += len(waiting[-1][0]) + MESSAGE_HEAD
        if size >= BLOCK_BYTES:
            yield _block(waiting)
            waiting, size = [], 0
    if waiting:
        yield _block(waiting)


def _block(parts: Sequence[tuple[Bytes, Places]]) -> Block:
    messages = [found for _, found in parts]
    return Block([data for data, _ in parts], np.concatenate(messages), np.cumsum(list(map(len, messages))))


def unpack(chunk: Chunk) -> list[Schema | Channel | tuple[Bytes, Places]]:
    """A chunk's schemas and channels; its bytes and the messages in them. Raises where it is not sound."""
    stream, size = get_chunk_data_stream(chunk, validate_crc=True)
    data = np.frombuffer(stream.read(size), np.uint8)
    messages = np.empty((size // (RECORD_HEAD + MESSAGE_HEAD) + 1, 5), np.int64)
    others = np.empty(size // RECORD_HEAD + 1, np.int64)
    found, beside = find_records(data, messages, others)
    if found < 0:
        raise ValueError("a chunk ends in the middle of a record")
    return [*_described(data, others[:beside].tolist()), (data, messages[:found])]


def _described(data: Bytes, places: Iterable[int]) -> Iterator[Schema | Channel]:
    for place in places:
        length = int.from_bytes(data[place + 1 : place + RECORD_HEAD].tobytes(), "little")
        own = data[place + RECORD_HEAD : place + RECORD_HEAD + length]
        content = ReadDataStream(BytesIO(own.tobytes()))
        if data[place] == Opcode.SCHEMA:
            yield Schema.read(content)
        elif data[place] == Opcode.CHANNEL:
            yield Channel.read(content)


def _alone(message: Message) -> tuple[Bytes, Places]:
    """A message that stands in no chunk."""
    data = np.frombuffer(message.data, np.uint8)
    times = message.log_time, message.publish_time
    return data, np.array([[message.channel_id, *times, 0, len(data)]], np.int64)
