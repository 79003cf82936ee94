"""One reading of an MCAP file from its start, as far as it is whole.

The seeking reader of the library needs the index at a file's end, which a torn file has not, and
holds a whole file in memory when asked for file order; so messages are always read in this way.
"""

import io
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TypeVar

import zstandard
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, MessageIndex, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.summary import Summary

from vsensor.errors import InputError

Item = TypeVar("Item")

PLAUSIBLE_BYTES = 64 << 20
PLAUSIBLE_RATIO = 100
"""No chunk is larger than the one, or than so many times its own bytes in the file, whatever it claims."""


class WholeReads(io.BufferedReader):
    """A file that gives all the bytes asked for, or none: the library does not look."""

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))
        self._size = self._left = path.stat().st_size

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        """Go to another place, and know what is left from there."""
        at = super().seek(offset, whence)
        self._left = self._size - at
        return at

    def read(self, size: int | None = -1, /) -> bytes:
        """Read so much; EndOfFile where so much is not left."""
        wanted = self._left if size is None or size < 0 else size
        if wanted > self._left:  # asked of us by a damaged length: do not make room for it
            raise EndOfFile
        self._left -= wanted
        return super().read(wanted)


class _Records(StreamReader):
    """A file's records, the messages' index left empty: a reading from the start has no use for it.

    The library would make a pair of Python's numbers of each of its entries: as many as there are messages.
    """

    def _read_record(self, opcode: int, length: int) -> McapRecord | None:
        if opcode == Opcode.MESSAGE_INDEX:
            return MessageIndex(channel_id=0, records=[])  # what is left of its bytes is passed over
        return super()._read_record(opcode, length)


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
                reader = _Records(file, emit_chunks=True)
                yield from self._walk(reader, file, unpack)
        except OSError as error:
            raise InputError(f"{self._path}: cannot be read: {error.strerror}") from error

    def messages(
        self, since_ns: int = 0, index: Summary | None = None
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
        self, reader: StreamReader, file: WholeReads, unpack: Callable[[Chunk], Iterable[Item]]
    ) -> Iterator[McapRecord | Item]:
        records = reader.records
        while True:
            try:
                record = next(records)
                inner = unpack(_deserving(record)) if isinstance(record, Chunk) else (record,)
            except StopIteration:
                self.finished = True
                return
            except OSError:
                raise
            except Exception as error:  # struct, zstd, lz4, UTF-8, CRC: all mean «not whole»
                self.fault = str(error) or "it ends in the middle of a record"
                return
            self.whole_bytes = file.tell()
            yield from inner


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
