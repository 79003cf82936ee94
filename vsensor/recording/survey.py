"""A first reading of a torn session: what of it can be saved, and what is lost."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from mcap.records import Channel, Schema

from vsensor.errors import InputError
from vsensor.recording.blocks import blocks
from vsensor.recording.index import Index
from vsensor.recording.layout import CHANNEL
from vsensor.recording.reader import Session
from vsensor.recording.scan import Scan

_CHANNELS = 1 << 16
"""So many can be told apart in a file."""


class NothingLeftError(InputError):
    """Not a message of a file can be read: there is nothing to save."""


@dataclass(frozen=True, slots=True)
class Survey:
    """What can be had from a torn session."""

    told: Index
    """All its schemas and channels: what is lost at one place may be told again at another."""
    lost_bytes: int
    lost: str
    """All that could not be read, in words; nothing where all could."""


def survey(session: Session) -> Survey:
    """Read a session through; NothingLeftError where no message in it can be read."""
    scan = Scan(session.path, through=True)
    told = Index()
    counts = np.zeros(_CHANNELS, np.int64)
    for record in blocks(scan):
        if isinstance(record, Schema):
            told.schemas.setdefault(record.id, record)
        elif isinstance(record, Channel):
            told.channels.setdefault(record.id, record)
        else:
            counts += np.bincount(record.messages[:, CHANNEL], minlength=_CHANNELS)
    if session.index:
        told.schemas = session.index.schemas | told.schemas
        told.channels = session.index.channels | told.channels
    lost = _in_words(session, scan, counts, told)
    if not counts[list(told.channels)].any():
        but = f"; {lost} could not be read" if lost else ""
        raise NothingLeftError(f"{session.path}: nothing of it could be saved: no message is in it{but}")
    return Survey(told, scan.holes.lost_bytes, lost)


def _in_words(session: Session, scan: Scan, counts: npt.NDArray[np.int64], told: Index) -> str:
    found = int(counts.sum())
    unknown = found - int(counts[list(told.channels)].sum())
    lost = [scan.holes.words()] if scan.holes else []
    if session.index and session.index.statistics and session.index.statistics.message_count > found:
        expected = session.index.statistics.message_count
        lost.append(f"{expected - found} of {expected} messages")
    if unknown:
        lost.append(f"{unknown} messages of channels that nothing tells of")
    return ", ".join(lost)
