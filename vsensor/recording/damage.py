"""What of a file cannot be read, and where behind it the next record begins that may be."""

import re

from mcap.opcode import Opcode
from mcap.stream_reader import MAGIC_SIZE

from vsensor.recording.whole import HEAD, WholeReads

TOLD = 8
"""So many places are told one by one."""
_PRIVATE = 0x80
"""From here on a record's opcode is for anybody's own use."""
_WINDOW = 1 << 20
_LONGEST = 64
"""More bytes than any pattern of the following has."""
_BEGINNINGS = re.compile(
    rb"\x06(?=.{5}\0{3}.{21}\0{3}.{4}(?:\0{4}|\x03\0{3}lz4|\x04\0{3}zstd))"  # a chunk
    rb"|\x0c(?=.{3}\0{5}.{2}\0{2})"  # metadata
    rb"|\x09(?=.{5}\0{3}.{18}\0{2})"  # an attachment
    rb"|\x0f(?=\x04\0{7})",  # the end of the data
    re.DOTALL,
)
"""How the records begin by which a reading finds its way again: those that stand in no chunk."""


class Holes:
    """The places of a file that could not be read, in its order; the first ones each, the others as a sum."""

    def __init__(self) -> None:
        self.lost_bytes = 0
        self.places: list[tuple[int, int]] = []
        """Where each of the first begins and ends."""
        self._count = 0
        self._last = (-1, -1)

    def __bool__(self) -> bool:
        return self._count > 0

    def add(self, begin: int, end: int) -> None:
        """Note one; what begins where the one before ends is one with it."""
        self.lost_bytes += end - begin
        if begin == self._last[1]:
            begin = self._last[0]
            del self.places[self._count - 1 :]
        else:
            self._count += 1
        self._last = begin, end
        if self._count <= TOLD:
            self.places.append(self._last)

    def words(self) -> str:
        """How much, and where."""
        told = ", ".join(f"{end - begin} bytes from byte {begin}" for begin, end in self.places)
        more = self._count - len(self.places)
        return told + (f" and {more} more places, {self.lost_bytes} bytes in all" if more else "")


def is_known(opcode: int) -> bool:
    """Whether MCAP has a record of this kind."""
    return Opcode.HEADER <= opcode <= Opcode.DATA_END or opcode >= _PRIVATE


def end_of(file: WholeReads, at: int) -> int | None:
    """Where the record at this place ends by its own word; None where that cannot be."""
    head = file.peek(at, HEAD.size)
    if len(head) < HEAD.size:
        return None
    opcode, length = HEAD.unpack(head)
    end: int = at + HEAD.size + length
    return end if is_known(opcode) and end <= file.size else None


def led_to(file: WholeReads, at: int) -> int | None:
    """Where the record here ends, if there the file ends or what looks like another record begins."""
    end = end_of(file, at)
    if end is None:
        return None
    rest = file.size - end
    if rest < HEAD.size:  # the end of the file, or a torn record's first bytes
        return end if not rest or rest == MAGIC_SIZE or is_known(file.peek(end, 1)[0]) else None
    return end if end_of(file, end) is not None else None


def next_record(file: WholeReads, start: int) -> int | None:
    """Where from a place on the next record begins that leads to another; None where there is none.

    Looks at each byte once, and believes no length before it has seen what stands at its end.
    """
    while window := file.peek(start, _WINDOW):
        for found in _BEGINNINGS.finditer(window):
            if led_to(file, start + found.start()) is not None:
                return start + found.start()
        if len(window) < _WINDOW:
            return None
        start += _WINDOW - _LONGEST
    return None
