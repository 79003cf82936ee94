"""Batches into a Rerun recording, by whole columns: a call costs some 250 µs an entity, whatever the rows."""

from collections.abc import Sequence

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from vsensor.view.batches import Batch, Lane, LaneLook, LogLine, Look, Page, Points
from vsensor.view.blueprint import TIMELINE


def send(recording: rr.RecordingStream, batch: Batch) -> None:
    """Hand one batch to Rerun: looks for all time, everything else at its place on the source's clock."""
    match batch:
        case Look():
            count = len(batch.names)
            style = rr.SeriesLines(
                names=batch.names, colors=[batch.colour] * count, widths=[batch.width] * count
            )
            recording.log(batch.entity, style, static=True)
        case LaneLook():
            states = rr.StateConfiguration(values=[*batch.colours], colors=[*batch.colours.values()])
            recording.log(batch.entity, states, static=True)
        case Points():
            rows, lines = batch.values.shape
            columns = rr.Scalars.columns(scalars=batch.values.ravel()).partition(np.full(rows, lines))
            recording.send_columns(batch.entity, [_times(batch.times_ns)], columns)
        case Lane():
            recording.send_columns(
                batch.entity, [_times([batch.time_ns])], rr.StateChange.columns(state=[batch.state])
            )
        case LogLine():
            columns = rr.TextLog.columns(text=[batch.text], level=[batch.level])
            recording.send_columns(batch.entity, [_times([batch.time_ns])], columns)
        case Page():
            columns = rr.TextDocument.columns(text=[batch.text], media_type=[rr.MediaType.MARKDOWN])
            recording.send_columns(batch.entity, [_times([batch.time_ns])], columns)


def _times(times_ns: NDArray[np.int64] | Sequence[int]) -> rr.TimeColumn:
    return rr.TimeColumn(TIMELINE, timestamp=np.asarray(times_ns, dtype=np.int64).astype("datetime64[ns]"))
