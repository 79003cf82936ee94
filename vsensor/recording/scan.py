"""One reading of an MCAP file from its start, as far as it is whole.

The seeking reader of the library needs the index at a file's end, which a torn file has not, and
holds a whole file in memory when asked for file order; so messages are always read in this way.
"""

import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TypeVar

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import MAGIC_SIZE, breakup_chunk, read_magic

from vsensor.errors import InputError
from vsensor.recording.index import Index
from vsensor.recording.whole import Content, WholeReads

Item = TypeVar("Item")

PLAUSIBLE_BYTES = 64 << 20
PLAUSIBLE_RATIO = 100
"""No chunk is larger than the one, or than so many times its own bytes in the file, whatever it claims."""

_CHUNK = struct.Struct("<QQQII")
"""Of a chunk: first and last time, size and checksum of what is packed, length of the compression's name."""
_LENGTH = struct.Struct("<Q")
_TELLING: Mapping[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.ATTACHMENT: Attachment.read,
    Opcode.METADATA: Metadata.read,
}


def _chunk(content: memoryview) -> Chunk:
    """A chunk. Its data are a view of the content: to copy them would cost as much as to read them."""
    start, end, size, crc, length = _CHUNK.unpack_from(content)
    at = _CHUNK.size + length
    (packed,) = _LENGTH.unpack_from(content, at)
    data = content[at + _LENGTH.size :][:packed]
    if len(data) < packed:
        raise EndOfFile
    return Chunk(str(content[_CHUNK.size : at], "utf-8"), data, end, start, crc, size)  # type: ignore[arg-type]


class Scan:
    """Reads a file's records until its end or until what cannot be read: a tear, or damage."""

    def __init__(self, path: Path) -> None:
        self.whole_bytes = 0
        """Where the last whole record ends."""
        self.finished = False
        """Whether the end of a complete file was reached."""
        self.count = 0
        """Messages so far."""
        self.fault = ""
        """What could not be read, where the reading stopped short."""
        self._path = path

    def records(self) -> Iterator[McapRecord]:
        """Yield the records, chunks unpacked, each chunk only when all of it is sound."""
        return self.unpacked(lambda chunk: breakup_chunk(chunk, validate_crc=True))

    def unpacked(self, unpack: Callable[[Chunk], Iterable[Item]]) -> Iterator[McapRecord | Item]:
        """Yield the records, and what `unpack` makes of each chunk; it raises where one is not sound."""
        try:
            with WholeReads(self._path) as file:
                yield from self._walk(file, unpack)
        except OSError as error:
            raise InputError(f"{self._path}: cannot be read: {error.strerror}") from error

    def messages(
        self, since_ns: int = 0, index: Index | None = None
    ) -> Iterator[tuple[Schema | None, Channel, Message]]:
        """Yield the messages in the order in which they stand in the file.

        With its `index` known, chunks that end before `since_ns` (log time) are passed over unread.
        """
        schemas = dict(index.schemas) if index else {}
        channels = {c.id: (schemas.get(c.schema_id), c) for c in index.channels.values()} if index else {}

        def unpack(chunk: Chunk) -> Iterable[McapRecord]:
            passed = index is not None and chunk.message_end_time < since_ns
            return () if passed else breakup_chunk(chunk, validate_crc=True)

        for record in self.unpacked(unpack):
            if isinstance(record, Message) and record.channel_id in channels:
                self.count += 1
                yield (*channels[record.channel_id], record)
            elif isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = (schemas.get(record.schema_id), record)

    def _walk(
        self, file: WholeReads, unpack: Callable[[Chunk], Iterable[Item]]
    ) -> Iterator[McapRecord | Item]:
        records = self._records(file)
        while True:
            try:
                record = next(records)
                inner = _inner(record, unpack)
            except StopIteration:
                self.finished = True
                return
            except OSError:
                raise
            except Exception as error:  # struct, zstd, lz4, UTF-8, CRC: all mean «not whole»
                self.fault = str(error) or "it ends in the middle of a record"
                return
            yield from inner

    def _records(self, file: WholeReads) -> Iterator[McapRecord | None]:
        """Yield a file's records up to its end, None for those that a reading from the start has no use for.

        Not by the library's own reader: it would look at each byte of the messages' indexes, and take them
        apart into as many pairs of Python's numbers as there are messages.
        """
        read_magic(Content(file.read(MAGIC_SIZE)))
        self.whole_bytes = file.tell()
        opcode = 0
        while opcode != Opcode.FOOTER:
            opcode, content = file.record()
            if not opcode:
                raise ValueError("zeros stand where a record was expected")
            yield _record(opcode, content)
            file.pass_over(Opcode.MESSAGE_INDEX)
            self.whole_bytes = file.tell()  # only now, as a chunk may be found not to be sound
        read_magic(Content(file.read(MAGIC_SIZE)))


def _record(opcode: int, content: memoryview) -> McapRecord | None:
    if opcode == Opcode.CHUNK:
        return _chunk(content)
    if opcode == Opcode.MESSAGE:
        message: Message = Message.read(Content(content), len(content))
        return message
    return _TELLING[opcode](Content(content)) if opcode in _TELLING else None


def _inner(
    record: McapRecord | None, unpack: Callable[[Chunk], Iterable[Item]]
) -> Iterable[McapRecord | Item]:
    if isinstance(record, Chunk):
        return unpack(_deserving(record))
    return () if record is None else (record,)


def _deserving(chunk: Chunk) -> Chunk:
    """The chunk, unless to unpack it would take memory out of all proportion; ValueError then.

    LZ4 packs no more than 255 bytes into one. Zstandard packs gigabytes of zeros into nothing, and the
    library makes the room that its frame asks for.
    """
    most = max(PLAUSIBLE_BYTES, PLAUSIBLE_RATIO * len(chunk.data))
    sizes = [chunk.uncompressed_size]
    if chunk.compression == "zstd":
        size = zstandard.get_frame_parameters(chunk.data).content_size
        sizes += [] if size == zstandard.CONTENTSIZE_UNKNOWN else [size]
    if max(sizes) > most:
        raise ValueError(f"a chunk of {len(chunk.data)} bytes claims to hold {max(sizes)}")
    return chunk
