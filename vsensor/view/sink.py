"""Batches into a Rerun recording, by whole columns: a call costs some 250 µs an entity, whatever the rows."""

from collections.abc import Sequence
from functools import singledispatch

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from vsensor.view.batches import (
    BandLook,
    Batch,
    DotLook,
    Labels,
    Lane,
    LaneLook,
    LogLine,
    Look,
    Measured,
    Page,
    Picture,
    Points,
    Strokes,
)
from vsensor.view.blueprint import TIMELINE


@singledispatch
def send(batch: Batch, recording: rr.RecordingStream) -> None:
    """Hand one batch to Rerun: looks for all time, everything else at its place on the source's clock."""
    raise TypeError(f"{recording} cannot hold a {type(batch).__name__}")


@send.register
def _(batch: Look, recording: rr.RecordingStream) -> None:
    style = rr.SeriesLines(names=batch.name, colors=[batch.colour], widths=[batch.width])
    recording.log(batch.entity, style, static=True)


@send.register
def _(batch: BandLook, recording: rr.RecordingStream) -> None:
    style = rr.Measurements.from_fields(names=[batch.name], colors=[batch.colour], widths=[batch.width])
    recording.log(batch.entity, style, static=True)


@send.register
def _(batch: DotLook, recording: rr.RecordingStream) -> None:
    style = rr.SeriesPoints(
        names=batch.name, colors=[batch.colour], markers="circle", marker_sizes=[batch.size]
    )
    recording.log(batch.entity, style, static=True)


@send.register
def _(batch: LaneLook, recording: rr.RecordingStream) -> None:
    states = rr.StateConfiguration(values=[*batch.colours], colors=[*batch.colours.values()])
    recording.log(batch.entity, states, static=True)


@send.register
def _(batch: Points, recording: rr.RecordingStream) -> None:
    _columns(recording, batch.entity, batch.times_ns, rr.Scalars.columns(scalars=batch.values))


@send.register
def _(batch: Measured, recording: rr.RecordingStream) -> None:
    # Rerun draws the band one root of this wide to both sides; how many deviations that is, the name tells.
    columns = rr.Measurements.columns(values=batch.values, variances=batch.bands**2)
    _columns(recording, batch.entity, batch.times_ns, columns)


@send.register
def _(batch: Lane, recording: rr.RecordingStream) -> None:
    _columns(recording, batch.entity, [batch.time_ns], rr.StateChange.columns(state=[batch.state]))


@send.register
def _(batch: LogLine, recording: rr.RecordingStream) -> None:
    columns = rr.TextLog.columns(text=[batch.text], level=[batch.level])
    _columns(recording, batch.entity, [batch.time_ns], columns)


@send.register
def _(batch: Page, recording: rr.RecordingStream) -> None:
    columns = rr.TextDocument.columns(text=[batch.text], media_type=[rr.MediaType.MARKDOWN])
    _columns(recording, batch.entity, [batch.time_ns], columns)


@send.register
def _(batch: Picture, recording: rr.RecordingStream) -> None:
    columns = rr.EncodedImage.columns(blob=[batch.png], media_type=["image/png"])
    _columns(recording, batch.entity, [batch.time_ns], columns)


@send.register
def _(batch: Strokes, recording: rr.RecordingStream) -> None:
    kind = rr.LineStrips3D if batch.lines and batch.lines[0].shape[1] == 3 else rr.LineStrips2D
    width = rr.Radius.ui_points(batch.width / 2)
    _place(recording, batch.entity, batch.time_ns, kind(batch.lines, colors=batch.colours, radii=width))


@send.register
def _(batch: Labels, recording: rr.RecordingStream) -> None:
    kind = rr.Points3D if batch.places.shape[1] == 3 else rr.Points2D
    points = kind(
        batch.places,
        labels=batch.texts,
        colors=batch.colours,
        radii=rr.Radius.ui_points(0.1),
        show_labels=True,
    )
    _place(recording, batch.entity, batch.time_ns, points)


def _columns(
    recording: rr.RecordingStream,
    entity: str,
    times_ns: NDArray[np.int64] | Sequence[int],
    columns: rr.ComponentColumnList,
) -> None:
    times = np.asarray(times_ns, dtype=np.int64).astype("datetime64[ns]")
    recording.send_columns(entity, [rr.TimeColumn(TIMELINE, timestamp=times)], columns)


def _place(recording: rr.RecordingStream, entity: str, time_ns: int, what: rr.AsComponents) -> None:
    recording.set_time(TIMELINE, timestamp=np.datetime64(time_ns, "ns"))
    recording.log(entity, what)
