"""One reading of an MCAP file from its start, as far as it is whole, or past what is not.

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
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import MAGIC_SIZE, breakup_chunk, read_magic

from vsensor.errors import InputError
from vsensor.recording.damage import Holes, led_to, next_record
from vsensor.recording.index import Index, attachment
from vsensor.recording.whole import HEAD, Content, WholeReads

Item = TypeVar("Item")

PLAUSIBLE_BYTES = 64 << 20
PLAUSIBLE_RATIO = 100
"""No chunk is larger than the one, or than so many times its own bytes in the file, whatever it claims."""

READ_AGAIN = 4
"""So many times a file's own size is read again in search of records; then what is left is given up."""

_CHUNK = struct.Struct("<QQQII")
"""Of a chunk: first and last time, size and checksum of what is packed, length of the compression's name."""
_LENGTH = struct.Struct("<Q")
_TELLING: Mapping[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
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
    """Reads a file's records until its end or until what cannot be read: a tear, or damage.

    With `through` it goes on behind damage, where another record can be found.
    """

    def __init__(self, path: Path, *, through: bool = False) -> None:
        self.whole_bytes = 0
        """Where the last whole record ends."""
        self.finished = False
        """Whether the end of a complete file was reached."""
        self.count = 0
        """Messages so far."""
        self.fault = ""
        """What could not be read, where the reading stopped short."""
        self.holes = Holes()
        """Where it could not be read, as far as the reading has come."""
        self._path = path
        self._through = through
        self._sure = 0
        """Behind what was read for certain: a length that is wrong may have led past a record."""
        self._again = 0
        self._chunked = False

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
        while not self.finished:
            at = file.tell()
            try:
                inner = self._next(file, unpack) if at else _begin(file)
            except OSError:
                raise
            except Exception as error:  # struct, zstd, lz4, UTF-8, CRC: all mean «not whole»
                self.fault = str(error) or "it ends in the middle of a record"
                place = self._behind(file, at) if self._through else None
                if place is None:
                    self.holes.add(at, file.size)
                    return
                self.holes.add(at if place > at else self._sure, place)
                self._sure = place
                file.seek(place)
                continue
            yield from inner
            self.whole_bytes = file.tell()

    def _next(
        self, file: WholeReads, unpack: Callable[[Chunk], Iterable[Item]]
    ) -> Iterable[McapRecord | Item]:
        """Read a record: what a reading from the start has use for in it. Raises where it is not sound.

        Not by the library's own reader: it would look at each byte of the messages' indexes, and take them
        apart into as many pairs of Python's numbers as there are messages.
        """
        at = file.tell()
        opcode, content = file.record()
        record, used = _record(opcode, content)
        inner = _inner(record, unpack)
        end = file.tell()
        file.pass_over(Opcode.MESSAGE_INDEX)
        if opcode == Opcode.FOOTER:
            read_magic(Content(file.read(MAGIC_SIZE)))
            self.finished = True
        elif self._through:
            self._check_is_in_place(opcode, indexed=file.tell() > end)
        self._sure = at + HEAD.size + used
        return inner

    def _check_is_in_place(self, opcode: int, *, indexed: bool) -> None:
        """Of a flipped bit in what a record is the record itself knows nothing, but its neighbours do."""
        if indexed and opcode not in (Opcode.CHUNK, Opcode.MESSAGE_INDEX):
            raise ValueError("the index of a chunk stands behind what is none")
        self._chunked |= opcode == Opcode.CHUNK
        if opcode == Opcode.MESSAGE and self._chunked:
            raise ValueError("a message stands outside of the chunks")

    def _behind(self, file: WholeReads, at: int) -> int | None:
        """Where to go on behind what cannot be read at this place; None where nothing can be."""
        if (place := led_to(file, at)) is not None:
            return place
        start = min(at, self._sure)
        self._again += file.tell() - start
        return next_record(file, start) if self._again <= READ_AGAIN * file.size else None


def _begin(file: WholeReads) -> Iterable[McapRecord]:
    read_magic(Content(file.read(MAGIC_SIZE)))
    return ()


def _record(opcode: int, content: memoryview) -> tuple[McapRecord | None, int]:
    """A record, None where nobody has use for it; and how many bytes of its content are surely its own."""
    if not opcode:
        raise ValueError("zeros stand where a record was expected")
    if opcode == Opcode.CHUNK:
        chunk = _chunk(content)
        return chunk, _CHUNK.size + len(chunk.compression) + _LENGTH.size + len(chunk.data)
    if opcode == Opcode.MESSAGE:
        message: Message = Message.read(Content(content), len(content))
        return message, len(content)
    if opcode == Opcode.ATTACHMENT:
        attached = attachment(content)
        return attached, len(content)
    if opcode not in _TELLING:
        return None, 0
    stream = Content(content)
    return _TELLING[opcode](stream), stream.count


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
