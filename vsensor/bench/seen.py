"""When a viewer has what was published: Rerun's own client hears what is drawn, and writes it to a file."""

import struct
import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rerun.chunk import RrdReader

from vsensor.bench.served import Onlooker
from vsensor.errors import VsensorError
from vsensor.view import series
from vsensor.view.blueprint import TIMELINE

Integers = NDArray[np.int64]

DRAWN = series.bit(series.SPEED, "now")
"""The line whose points are looked for."""

_STREAM_HEAD = 12
_MESSAGE_HEAD = struct.Struct("<QQ")
"""Kind and length of what follows."""
_DATA = 2
_OF_A_RECORDING = b"\x08\x01"
"""Where a message of data names what it belongs to: a recording, and not a layout."""


def delays_ns(published: Sequence[tuple[int, int]], seen: Onlooker) -> Integers:
    """How long after its publication each estimate was at the client, ns.

    published: for each estimate when it was published (monotonic clock) and its time (source clock). One that
    is thinned out has come with the next that is drawn; the last ones, which nothing followed, do not count.
    """
    newest_ns, come_ns = _come(seen)
    told = np.array(published, dtype=np.int64).reshape(-1, 2)
    at = np.searchsorted(newest_ns, told[:, 1])
    followed = at < len(newest_ns)
    return np.asarray(come_ns[at[followed]] - told[followed, 0])


def _come(seen: Onlooker) -> tuple[Integers, Integers]:
    """The newest time that is drawn, ascending, and when it was there."""
    written = seen.file.read_bytes()
    ends, end = _ends(written)
    whole = seen.file.with_suffix(".whole.rrd")  # the other is still being written
    whole.write_bytes(written[:end])
    sizes = np.array([growth.size for growth in seen.growths], dtype=np.int64)
    times = np.array([growth.at_ns for growth in seen.growths], dtype=np.int64)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it has no footer
        chunks = list(RrdReader(whole).stream())
    if len(chunks) != len(ends):
        raise VsensorError(f"{whole}: {len(chunks)} pieces of {len(ends)}: not as Rerun 0.41 writes")
    newest, come = [], []
    for chunk, end in zip(chunks, ends, strict=True):
        at = int(np.searchsorted(sizes, end))
        if chunk.entity_path == DRAWN and TIMELINE in chunk.timeline_names and at < len(times):
            column = chunk.to_record_batch().column(TIMELINE).to_numpy(zero_copy_only=False)
            newest.append(int(column.astype("datetime64[ns]").astype(np.int64).max()))
            come.append(int(times[at]))
    return np.maximum.accumulate(np.array(newest, dtype=np.int64)), np.array(come, dtype=np.int64)


def _ends(written: bytes) -> tuple[list[int], int]:
    """Where each message of a recording's data ends in a Rerun file, and where the last of all does."""
    ends = []
    begun = _STREAM_HEAD
    while begun + _MESSAGE_HEAD.size <= len(written):
        kind, length = _MESSAGE_HEAD.unpack_from(written, begun)
        at = begun + _MESSAGE_HEAD.size
        if at + length > len(written):
            break
        # A message begins with the tag and the length of its owner's name, a byte each.
        if kind == _DATA and written[at + 2 : at + 4] == _OF_A_RECORDING:
            ends.append(at + length)
        begun = at + length
    return ends, begun
