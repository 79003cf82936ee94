"""A session's samples and estimates as columns of numbers."""

import math
from array import array
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Estimate, Sample
from vsensor.quality import Quality
from vsensor.recording.reader import Record
from vsensor.tables import ESTIMATE_FIELDS, Floats, SurfaceTable

_Times = npt.NDArray[np.int64]
_CHANNELS = (SURFACE_TORQUE, SURFACE_SPEED)
_WORDS = {int(quality): quality.name.lower() for quality in Quality}


def surface_table(records: Iterable[Record]) -> SurfaceTable:
    """Gather surface samples into rows of equal time, in the order of time.

    Where a channel has no sample at a row's time it is NaN; of several the first counts.
    """
    times = {topic: array("q") for topic in _CHANNELS}
    values = {topic: array("d") for topic in _CHANNELS}
    for topic, message, _, _ in records:
        if topic in times and isinstance(message, Sample):
            times[topic].append(message.time_ns)
            values[topic].append(message.value)
    rows = np.union1d(*(np.asarray(column) for column in times.values()))
    torque, speed = (_at(rows, np.asarray(times[topic]), np.asarray(values[topic])) for topic in _CHANNELS)
    return SurfaceTable(np.array([_seconds(time_ns) for time_ns in rows.tolist()]), torque, speed)


def estimate_columns(estimates: Iterable[Estimate]) -> dict[str, npt.NDArray[Any]]:
    """Gather estimates into the columns of an estimates table; NaN where a field is not set."""
    numbers = [(field, array("d")) for column, field in ESTIMATE_FIELDS.items() if column != "quality"]
    verdicts: list[str | None] = []
    for estimate in estimates:
        for field, column in numbers:
            column.append(_number(estimate, field))
        verdicts.append(_WORDS.get(estimate.quality))
    columns = [*(np.asarray(column) for _, column in numbers), np.array(verdicts, dtype=object)]
    return dict(zip(ESTIMATE_FIELDS, columns, strict=True))


def _number(estimate: Estimate, field: str) -> float:
    if not estimate.HasField(field):  # type: ignore[arg-type]
        return math.nan
    value = getattr(estimate, field)
    return _seconds(value) if field.endswith("_ns") else float(value)


def _seconds(time_ns: int) -> float:
    """The nearest double; dividing floats would round twice."""
    return time_ns / 1_000_000_000


def _at(rows: _Times, times: _Times, values: Floats) -> Floats:
    column = np.full(len(rows), math.nan)
    known, first = np.unique(times, return_index=True)
    column[np.searchsorted(rows, known)] = values[first]
    return column
