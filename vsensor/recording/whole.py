"""Reads that give all the bytes asked for, or none: what a record of a file that is torn needs."""

import io
import os
import struct
from pathlib import Path
from types import TracebackType
from typing import Self

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile

HEAD = struct.Struct("<BQ")
"""Of a record: what it is, and how many bytes of content follow."""
ROOM_BYTES = 256 << 10
"""So much of a file is read at a time, always into the same room, which stays in the processor's cache."""


class WholeReads:
    """A file that gives all the bytes asked for, or none: the library does not look."""

    def __init__(self, path: Path) -> None:
        self._file = io.FileIO(path)
        self.size = path.stat().st_size
        """Bytes of the file."""
        self._room = memoryview(bytearray(ROOM_BYTES))
        self._begin = 0
        """Where in the file the room begins;"""
        self._at = self._end = 0
        """where in the room the next read does, and where what is in it ends."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def tell(self) -> int:
        """Where in the file the next read begins."""
        return self._begin + self._at

    def seek(self, place: int) -> None:
        """Go to another place."""
        self._file.seek(place)
        self._begin, self._at, self._end = place, 0, 0

    def seek_from_end(self, count: int) -> None:
        """Go to where so many bytes are left; EndOfFile where there never were so many."""
        if count > self.size:
            raise EndOfFile
        self.seek(self.size - count)

    def read(self, count: int) -> bytes:
        """Read so much; EndOfFile where so much is not left."""
        self._hold(count)
        self._at += count
        return bytes(self._room[self._at - count : self._at])

    def record(self) -> tuple[int, memoryview]:
        """Read a record: what it is, and its content; EndOfFile where it is not whole.

        The content is seen where it was read: the next read writes over it.
        """
        if self._end - self._at < HEAD.size:
            self._hold(HEAD.size)
        opcode, length = HEAD.unpack_from(self._room, self._at)
        count = HEAD.size + length
        if self._end - self._at < count:
            self._hold(count)
        content = self._room[self._at + HEAD.size : self._at + count]
        self._at += count
        return opcode, content

    def peek(self, place: int, count: int) -> bytes:
        """The bytes at another place, fewer where the file ends; the next read is not moved."""
        return os.pread(self._file.fileno(), count, place)

    def pass_over(self, opcode: int) -> None:
        """Pass over the records of this kind that come next, as far as they are in the room."""
        room, at, end = self._room, self._at, self._end - HEAD.size
        while at <= end:
            kind, length = HEAD.unpack_from(room, at)
            if kind != opcode or length > end - at:
                break
            at += HEAD.size + length
        self._at = at

    def _hold(self, count: int) -> None:
        """Have so many bytes in the room from here on."""
        if count > self.size - self.tell():  # asked of us by a damaged length: do not make room for it
            raise EndOfFile
        held = self._room[self._at : self._end]
        room = self._room if count <= len(self._room) else memoryview(bytearray(count))
        room[: len(held)] = held
        self._begin += self._at
        self._room, self._at, self._end = room, 0, len(held)
        while self._end < count:
            came = self._file.readinto(room[self._end :])
            if not came:
                raise EndOfFile
            self._end += came


class Content(ReadDataStream):
    """A record's content, which gives all the bytes asked for, or none."""

    def __init__(self, content: bytes | memoryview) -> None:
        super().__init__(io.BytesIO(content))

    def read(self, length: int) -> bytes:
        """Read so much; EndOfFile where so much is not left."""
        data = super().read(length)
        if len(data) < length:
            raise EndOfFile
        return data
