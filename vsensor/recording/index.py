"""What stands at the end of a complete session: what it holds, and where.

Not by the library's own reader, which makes a record of Python's numbers for each chunk: a kilobyte for
each second that was recorded.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Footer,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from vsensor.recording.whole import HEAD, Content, WholeReads

_END = HEAD.size + 20 + 8
"""Bytes of the footer and of the magic behind it."""
_BEFORE_PLACES = struct.Struct("<32xI")
"""Of a chunk's index: behind times and place of the chunk, how many bytes the places of its messages take."""
_PLACE = struct.Struct("<HQ")
"""Of each channel, where in the file the index of its messages in this chunk stands."""


@dataclass(slots=True)
class Index:
    """The end of a session, as far as anybody asks for it."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    statistics: Statistics | None = None
    first: dict[int, int] = field(default_factory=dict)
    """Of each channel, where the index of its messages stands behind the first chunk that has any;"""
    last: dict[int, int] = field(default_factory=dict)
    """and behind the last."""
    noted: list[Attachment | Metadata] = field(default_factory=list)
    """What stands beside the messages: attachments, then metadata."""


def read_index(file: WholeReads) -> Index | None:
    """Read a file's index; None where it says that it has none. Any exception means: it is not complete."""
    file.seek_from_end(_END)
    opcode, content = file.record()
    if opcode != Opcode.FOOTER:
        raise ValueError("it does not end in a footer")
    footer = Footer.read(Content(content))
    if not footer.summary_start:
        return None
    index = Index()
    attachments: list[AttachmentIndex] = []
    metadata: list[MetadataIndex] = []
    file.seek(footer.summary_start)
    for opcode, content in _until_footer(file):
        if opcode == Opcode.CHUNK_INDEX:
            _note_places(index, content)
        elif opcode == Opcode.SCHEMA:
            schema = Schema.read(Content(content))
            index.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(Content(content))
            index.channels[channel.id] = channel
        elif opcode == Opcode.STATISTICS:
            index.statistics = Statistics.read(Content(content))
        elif opcode == Opcode.ATTACHMENT_INDEX:
            attachments.append(AttachmentIndex.read(Content(content)))
        elif opcode == Opcode.METADATA_INDEX:
            metadata.append(MetadataIndex.read(Content(content)))
    index.noted += (attachment(_at(file, at.offset, Opcode.ATTACHMENT)) for at in attachments)
    index.noted += (Metadata.read(Content(_at(file, at.offset, Opcode.METADATA))) for at in metadata)
    return index


def attachment(content: memoryview) -> Attachment:
    """An attachment of a record's content; ValueError where its checksum is that of another."""
    read: Attachment = Attachment.read(Content(content))
    checksum = int.from_bytes(content[-4:], "little")
    if checksum and checksum != zlib.crc32(content[:-4]):
        raise ValueError(f"the attachment {read.name} has another checksum than is noted")
    return read


def _until_footer(file: WholeReads) -> Iterator[tuple[int, memoryview]]:
    opcode, content = file.record()
    while opcode != Opcode.FOOTER:
        yield opcode, content
        opcode, content = file.record()


def _note_places(index: Index, content: memoryview) -> None:
    (length,) = _BEFORE_PLACES.unpack_from(content)
    places = dict(_PLACE.iter_unpack(content[_BEFORE_PLACES.size : _BEFORE_PLACES.size + length]))
    index.first = places | index.first
    index.last |= places


def _at(file: WholeReads, place: int, expected: int) -> memoryview:
    file.seek(place)
    opcode, content = file.record()
    if opcode != expected:
        raise ValueError(f"another record stands at byte {place} than its index says")
    return content
