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
    END,
    MESSAGE_HEAD,
    RECORD_HEAD,
    START,
    Bytes,
    Places,
    find_records,
)
from vsensor.recording.scan import Scan

BLOCK_BYTES = 2 << 20
"""Chunks are joined to so much: below, NumPy's cost of a call counts; above, the processor's cache misses."""


class Block(NamedTuple):
    """Messages as they stand in the file, in its order."""

    data: Bytes
    messages: Places
    """What `layout` finds of each, shape (n, 5)."""


def blocks(scan: Scan) -> Iterator[Schema | Channel | Block]:
    """Yield a session's schemas and channels, and its messages in blocks: what tells of them comes before."""
    waiting: list[Block] = []
    size = 0
    for record in scan.unpacked(unpack):
        if isinstance(record, Message):
            record = _alone(record)
        if isinstance(record, Block):
            waiting.append(record)
            size += len(record.data)
        elif isinstance(record, Schema | Channel):
            yield record
        if size >= BLOCK_BYTES:
            yield _joined(waiting)
            waiting, size = [], 0
    if waiting:
        yield _joined(waiting)


def unpack(chunk: Chunk) -> list[Schema | Channel | Block]:
    """A chunk's schemas and channels, and its messages as a block. Raises where it is not sound."""
    stream, size = get_chunk_data_stream(chunk, validate_crc=True)
    data = np.frombuffer(stream.read(size), np.uint8)
    messages = np.empty((size // (RECORD_HEAD + MESSAGE_HEAD) + 1, 5), np.int64)
    others = np.empty(size // RECORD_HEAD + 1, np.int64)
    found, beside = find_records(data, messages, others)
    if found < 0:
        raise ValueError("a chunk ends in the middle of a record")
    return [*_described(data, others[:beside].tolist()), Block(data, messages[:found])]


def _described(data: Bytes, places: Iterable[int]) -> Iterator[Schema | Channel]:
    for place in places:
        content = ReadDataStream(BytesIO(data[place + RECORD_HEAD :].tobytes()))
        if data[place] == Opcode.SCHEMA:
            yield Schema.read(content)
        elif data[place] == Opcode.CHANNEL:
            yield Channel.read(content)


def _alone(message: Message) -> Block:
    """A message that stands in no chunk."""
    data = np.frombuffer(message.data, np.uint8)
    times = message.log_time, message.publish_time
    return Block(data, np.array([[message.channel_id, *times, 0, len(data)]], np.int64))


def _joined(parts: Sequence[Block]) -> Block:
    begins = np.cumsum([0, *(len(part.data) for part in parts)])
    messages = np.concatenate([part.messages for part in parts])
    shift = np.repeat(begins[:-1], [len(part.messages) for part in parts])
    messages[:, START] += shift
    messages[:, END] += shift
    return Block(np.concatenate([part.data for part in parts]), messages)
