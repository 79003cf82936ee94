"""Reads that give all the bytes asked for, or none: what a record of a file that is torn needs."""

import io
import struct
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile

HEAD = struct.Struct("<BQ")
"""Of a record: what it is, and how many bytes of content follow."""


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

    def record(self) -> tuple[int, bytes]:
        """Read a record: what it is, and its content; EndOfFile where it is not whole.

        In one call, as a session has ten small records for each second.
        """
        read = super().read
        head = read(HEAD.size)
        if len(head) < HEAD.size:
            raise EndOfFile
        opcode, length = HEAD.unpack(head)
        self._left -= HEAD.size
        if length > self._left:
            raise EndOfFile
        self._left -= length
        return opcode, read(length)


class Content(ReadDataStream):
    """A record's content, which gives all the bytes asked for, or none."""

    def __init__(self, content: bytes) -> None:
        super().__init__(io.BytesIO(content))

    def read(self, length: int) -> bytes:
        """Read so much; EndOfFile where so much is not left."""
        data = super().read(length)
        if len(data) < length:
            raise EndOfFile
        return data
