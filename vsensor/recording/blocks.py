"""A session's messages in blocks: the bytes of some chunks, and where in them each message stands."""

import struct
from collections.abc import Iterable, Iterator
from io import BytesIO
from typing import NamedTuple

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, UnsupportedCompressionError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Schema
from mcap.stream_reader import CRCValidationError
from zlib_ng import zlib_ng

from vsensor.recording.layout import MESSAGE_HEAD, RECORD_HEAD, Bytes, Places, find_records
from vsensor.recording.scan import PLAUSIBLE_BYTES, Scan

BLOCK_BYTES = 2 << 20
"""Messages of so many bytes are taken together: of fewer, NumPy's cost of a call would count."""


_SEQUENCE = struct.Struct("<I16x")
"""The end of a message's head: its number, and its two times."""


class Block(NamedTuple):
    """Messages in the file's order. Their place is used again for the next block."""

    data: Bytes
    """The bytes of some chunks, unpacked."""
    messages: Places
    """What `layout` finds of each, shape (n, 5)."""

    def records(self) -> Iterator[Message]:
        """Yield the messages one by one."""
        for channel, log_time, publish_time, start, end in self.messages.tolist():
            (sequence,) = _SEQUENCE.unpack_from(self.data.data, start - _SEQUENCE.size)
            data = self.data[start:end].tobytes()
            yield Message(channel, log_time, data, publish_time, sequence)


def blocks(scan: Scan) -> Iterator[Schema | Channel | Block]:
    """Yield a session's schemas and channels, and its messages in blocks: what tells of them comes before."""
    place = _Place()
    for record in scan.unpacked(place.unpack):
        if isinstance(record, Message):
            place.add(record)
            if place.used >= BLOCK_BYTES:
                yield place.block()
        elif isinstance(record, Schema | Channel | Block):
            yield record
    if place.used:
        yield place.block()


class _Place:
    """Where chunks are unpacked, the same all along: to have new room each time costs as much again."""

    def __init__(self) -> None:
        self.used = 0
        """Bytes."""
        self._found = 0
        self._data = np.empty(0, np.uint8)
        self._messages = np.empty((0, 5), np.int64)
        self._others = np.empty(0, np.int64)
        self._zstd = zstandard.ZstdDecompressor(max_window_size=PLAUSIBLE_BYTES)

    def unpack(self, chunk: Chunk) -> list[Schema | Channel | Block]:
        """Add a chunk: its schemas and channels, the block that it fills. Raises where it is not sound."""
        start = self.used
        end = start + len(self._unpacked(chunk))
        messages = self._messages[self._found :]
        found, beside = find_records(self._data[:end], start, messages, self._others)
        if found < 0:
            raise ValueError("a chunk ends in the middle of a record")
        described = list(_described(self._data[:end], self._others[:beside].tolist()))
        self.used = end
        self._found += found
        return [*described, *([self.block()] if end >= BLOCK_BYTES else [])]

    def add(self, message: Message) -> None:
        """Add a message that stands in no chunk."""
        room = self._room(RECORD_HEAD + MESSAGE_HEAD + len(message.data))
        self.used += len(room)
        start = self.used - len(message.data)
        _SEQUENCE.pack_into(self._data.data, start - _SEQUENCE.size, message.sequence)
        self._data[start : self.used] = np.frombuffer(message.data, np.uint8)
        times = message.log_time, message.publish_time
        self._messages[self._found] = message.channel_id, *times, start, self.used
        self._found += 1

    def block(self) -> Block:
        """All that was added; what comes next is written over it."""
        block = Block(self._data[: self.used], self._messages[: self._found])
        self.used = self._found = 0
        return block

    def _unpacked(self, chunk: Chunk) -> Bytes:
        """What a chunk holds, behind what is there already."""
        if chunk.compression == "zstd":
            size = zstandard.get_frame_parameters(chunk.data).content_size
            room = self._room(chunk.uncompressed_size if size == zstandard.CONTENTSIZE_UNKNOWN else size)
            if len(room) and self._zstd.stream_reader(chunk.data).readinto(room.data) < len(room):
                raise EndOfFile
        elif chunk.compression in ("lz4", ""):
            data = lz4.frame.decompress(chunk.data) if chunk.compression else chunk.data
            room = self._room(len(data))
            room[:] = np.frombuffer(data, np.uint8)
        else:
            raise UnsupportedCompressionError(chunk.compression)
        # Not Python's own zlib: of a session in zstd it took every seventh moment of a reading.
        checksum = zlib_ng.crc32(room.data) if chunk.uncompressed_crc else 0
        if checksum != chunk.uncompressed_crc:
            raise CRCValidationError(expected=chunk.uncompressed_crc, actual=checksum, record=chunk)
        return room

    def _room(self, size: int) -> Bytes:
        """Room for so many bytes, and for what can be found in them."""
        end = self.used + size
        if end > len(self._data):
            most = max(end, 2 * BLOCK_BYTES)
            self._data = _longer(self._data, most)
            self._messages = _longer(self._messages, most // (RECORD_HEAD + MESSAGE_HEAD) + 1)
            self._others = _longer(self._others, most // RECORD_HEAD + 1)
        return self._data[self.used : end]


def _longer(array: np.ndarray, size: int) -> np.ndarray:
    longer = np.empty((size, *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


def _described(data: Bytes, places: Iterable[int]) -> Iterator[Schema | Channel]:
    for place in places:
        length = int.from_bytes(data[place + 1 : place + RECORD_HEAD].tobytes(), "little")
        own = data[place + RECORD_HEAD : place + RECORD_HEAD + length]
        content = ReadDataStream(BytesIO(own.tobytes()))
        if data[place] == Opcode.SCHEMA:
            yield Schema.read(content)
        elif data[place] == Opcode.CHANNEL:
            yield Channel.read(content)
