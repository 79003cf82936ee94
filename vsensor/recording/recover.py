"""A torn session made whole: all that survived, with an index, under a proper name."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from vsensor.recording.blocks import Block, blocks
from vsensor.recording.index import Index
from vsensor.recording.names import recovering
from vsensor.recording.reader import Session
from vsensor.recording.scan import Scan
from vsensor.recording.survey import survey
from vsensor.recording.writer import COULD_NOT_BE_READ, RECORDER, RECOVERED_FROM, SessionWriter


@dataclass(frozen=True, slots=True)
class Recovered:
    """The mended session, the messages in it, and what of the torn one is not: bytes, and all in words."""

    path: Path
    messages: int
    lost_bytes: int
    lost: str


def recover(torn: Path, output: Path | None = None) -> Recovered:
    """Write a whole session from a torn one, which is left as it is.

    NAME.mcap.part becomes NAME.mcap, and NAME.mcap becomes NAME.recovered.mcap, unless `output`
    names another. Raises InputError where `torn` is no session or `output` exists, NothingLeftError
    where there is nothing to save.
    """
    session = Session(torn)
    found = survey(session)
    path = output or _mended(torn)
    with SessionWriter(
        path,
        configuration=session.configuration or "",
        metadata={**session.metadata, RECOVERED_FROM: torn.name, **_loss(session.metadata, found.lost)},
        compression="zstd",
        part=recovering(path),
    ) as writer:
        for record in blocks(Scan(torn, through=True)):
            if isinstance(record, Block):
                _copy(record, found.told, writer)
        if session.recorder:
            writer.note(RECORDER, session.recorder)
    return Recovered(path, writer.written, found.lost_bytes, found.lost)


def _copy(block: Block, told: Index, writer: SessionWriter) -> None:
    for message in block.records():
        if (channel := told.channels.get(message.channel_id)) is not None:
            writer.copy(told.schemas.get(channel.schema_id), channel, message)


def _loss(earlier: Mapping[str, str], lost: str) -> dict[str, str]:
    """What a mended session says of its loss, with that of the one before, where that was mended too."""
    told = [lost, earlier.get(COULD_NOT_BE_READ, "")]
    said = "; and before: ".join(filter(None, told))
    return {COULD_NOT_BE_READ: said} if said else {}


def _mended(torn: Path) -> Path:
    return torn.with_suffix("") if torn.suffix == ".part" else torn.with_suffix(".recovered.mcap")
