"""A torn session made whole: all that survived, with an index, under a proper name."""

from dataclasses import dataclass
from pathlib import Path

from vsensor.recording.reader import Session
from vsensor.recording.scan import Scan
from vsensor.recording.writer import RECORDER, SessionWriter

RECOVERED_FROM = "recovered_from"
"""Key of a session's metadata: the name of the torn one."""


@dataclass(frozen=True, slots=True)
class Recovered:
    """The mended session, the messages in it, and the bytes at the torn one's end that told nothing."""

    path: Path
    messages: int
    lost_bytes: int


def recover(torn: Path, output: Path | None = None) -> Recovered:
    """Write a whole session from a torn one, which is left as it is.

    NAME.mcap.part becomes NAME.mcap, and NAME.mcap becomes NAME.recovered.mcap, unless `output`
    names another. Raises InputError where `torn` is no session or `output` exists.
    """
    session = Session(torn)
    scan = Scan(torn)
    metadata = {**session.metadata, RECOVERED_FROM: torn.name}
    path = output or _mended(torn)
    with SessionWriter(
        path,
        configuration=session.configuration or "",
        metadata=metadata,
        compression="zstd",
        part=recovering(path),
    ) as writer:
        for schema, channel, message in scan.messages():
            writer.copy(schema, channel, message)
        if session.recorder:
            writer.note(RECORDER, session.recorder)
    lost = 0 if scan.finished else torn.stat().st_size - scan.whole_bytes
    return Recovered(path, writer.written, lost)


def recovering(path: Path) -> Path:
    """Where a session is written while it is mended: NAME.mcap.part may be the torn one itself."""
    return path.with_name(f"{path.name}.recovering")


def _mended(torn: Path) -> Path:
    return torn.with_suffix("") if torn.suffix == ".part" else torn.with_suffix(".recovered.mcap")
