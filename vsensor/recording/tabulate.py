"""A session's samples and estimates as columns of numbers, a piece of the session at a time."""

import math
from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from vsensor.grid import seconds
from vsensor.messages import BIT_ESTIMATE, SURFACE_SPEED, SURFACE_TORQUE
from vsensor.quality import Quality
from vsensor.recording.columns import Columns, read_columns
from vsensor.recording.reader import Session
from vsensor.tables import DEPTH_COLUMNS, ESTIMATE_FIELDS, Floats, SurfaceTable

_Times = npt.NDArray[np.int64]
_CHANNELS = (SURFACE_TORQUE, SURFACE_SPEED)
_NEVER = np.iinfo(np.int64).max

_WORDS = np.array([None, *(Quality(value).name.lower() for value in (1, 2, 3))], dtype=object)


def estimate_tables(session: Session) -> Iterator[Mapping[str, npt.NDArray[Any]]]:
    """Yield a session's estimates as columns of an estimates table; NaN where a field is not set."""
    for piece in read_columns(session, {BIT_ESTIMATE: ESTIMATE_FIELDS.values()}):
        if BIT_ESTIMATE in piece:
            estimates = piece[BIT_ESTIMATE]
            yield {column: _column(estimates, field) for column, field in ESTIMATE_FIELDS.items()}


def surface_tables(session: Session) -> Iterator[SurfaceTable]:
    """Yield surface samples in rows of equal time, in the order of time, all over the session.

    Where a channel has no sample at a row's time it is NaN; of several the first counts. So it is with
    depths, where the session holds any. It is read twice: once for when the times of the rest of it begin,
    before which all rows are complete.
    """
    rest, topics = _begins_of_rests(session)
    wanted = dict.fromkeys(topics, ("time_ns", "value"))
    held = {topic: (np.empty(0, np.int64), np.empty(0)) for topic in topics}
    for piece, until in zip(read_columns(session, wanted), rest, strict=True):
        for topic, columns in piece.items():
            came = columns.values["time_ns"], columns.values["value"]
            held[topic] = tuple(map(np.append, held[topic], came))  # type: ignore[assignment]
        ready = {topic: times < until for topic, (times, _) in held.items()}
        rows = _rows(
            {topic: (times[ready[topic]], values[ready[topic]]) for topic, (times, values) in held.items()}
        )
        held = {
            topic: (times[~ready[topic]], values[~ready[topic]]) for topic, (times, values) in held.items()
        }
        if len(rows.time_s):
            yield rows


def _begins_of_rests(session: Session) -> tuple[list[int], Collection[str]]:
    """For each piece of a session, the earliest time of what comes behind it; and what it holds."""
    wanted = dict.fromkeys((*_CHANNELS, *DEPTH_COLUMNS), ("time_ns",))
    earliest, found = [], dict.fromkeys(_CHANNELS)
    for piece in read_columns(session, wanted):
        earliest.append(
            min((int(columns.values["time_ns"].min()) for columns in piece.values()), default=_NEVER)
        )
        found.update(dict.fromkeys(piece))
    behind = np.minimum.accumulate([_NEVER, *reversed(earliest[1:])])
    return [int(time) for time in reversed(behind)] if earliest else [], [*found]


def _rows(channels: Mapping[str, tuple[_Times, Floats]]) -> SurfaceTable:
    rows = np.unique(np.concatenate([times for times, _ in channels.values()]))
    columns = {topic: _at(rows, *channel) for topic, channel in channels.items()}
    torque, speed = (columns.pop(topic) for topic in _CHANNELS)
    return SurfaceTable(rows, torque, speed, columns)


def _at(rows: _Times, times: _Times, values: Floats) -> Floats:
    column = np.full(len(rows), math.nan)
    known, first = np.unique(times, return_index=True)
    column[np.searchsorted(rows, known)] = values[first]
    return column


def _column(estimates: Columns, field: str) -> npt.NDArray[Any]:
    values = estimates.values[field]
    if field == "quality":
        known = (values > 0) & (values < len(_WORDS))
        return np.asarray(_WORDS[np.where(known, values, 0)])
    if field.endswith("_ns"):
        return np.where(estimates.known[field], seconds(values), math.nan)
    return estimates.number(field)
