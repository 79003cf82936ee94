"""The string in space and time: depth down, time across, a quantity along the string as colour."""

import io
from collections import deque
from collections.abc import Callable, Iterator
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from vsensor.grid import NS
from vsensor.messages import Message, Profile
from vsensor.view.batches import Batch, Floats, Labels, Picture, Strokes
from vsensor.view.charts.chart import Scale, axis
from vsensor.view.palette import GREY, GROUND, scale
from vsensor.view.part import Every, Part
from vsensor.view.units import Units

COLUMNS, ROWS = 240, 130
"""Pixels of the picture: across, one for each of the newest times; down, depths from top to bit."""
LIFT = 7.0
"""Rerun hangs a label below its place by about so much."""
BAR_FROM, BAR_TO = COLUMNS + 8, COLUMNS + 16
"""Columns of the scale of colours beside it."""
BOUNDS = (-36.0, BAR_TO + 30.0), (-26.0, ROWS + 36.0)
"""What of the plane is shown."""
EVERY_NS = NS
_UNKNOWN = 0
"""The palette's first colour, of what is not known."""


class SpaceTime(Part):
    """A quantity along the string over the last `span_s` seconds of confirmed answers."""

    def __init__(
        self, entity: str, quantity: Literal["speed", "torque"], units: Units, span_s: float
    ) -> None:
        self._entity = entity
        self._factor = units.speed_factor if quantity == "speed" else units.torque_factor
        self._field = "speed_rad_s" if quantity == "speed" else "torque_nm"
        self._unit = units.speed if quantity == "speed" else units.torque
        self._column_ns = round(span_s * 1e9 / COLUMNS)
        self._profiles: deque[tuple[int, NDArray[np.float32]]] = deque(maxlen=2 * COLUMNS)
        self._length = 0.0
        self._scale = Scale()
        self._every = Every(EVERY_NS)

    def take(self, message: Message) -> None:
        """Take in a profile."""
        if not isinstance(message, Profile) or not message.depth_m:
            return
        depth = np.array(message.depth_m)
        values = np.array(getattr(message, self._field)) * self._factor
        self._length = depth[-1]
        rows = np.interp(np.linspace(0.0, depth[-1], ROWS), depth, values)
        self._profiles.append((message.time_ns, rows.astype(np.float32)))

    def batches(self) -> Iterator[Batch]:
        """The picture, once a second."""
        if not self._profiles or not self._every.due(self.at_ns):
            return
        newest_ns = self._profiles[-1][0]
        field = self._field_at(newest_ns)
        values = self._scale.follow(field[np.isfinite(field)])
        yield Picture(f"{self._entity}/picture", self.at_ns, _png(values.shares(field)))
        yield from self._axes(self.at_ns, values.ticks(), values.shares(values.ticks()), values.text)

    def _field_at(self, newest_ns: int) -> Floats:
        """The quantity by row and column, NaN where no profile came; shape (ROWS, COLUMNS)."""
        times = np.array([time_ns for time_ns, _ in self._profiles])
        columns = COLUMNS - 1 - (newest_ns - times) // self._column_ns
        field = np.full((ROWS, COLUMNS), np.nan)
        inside = np.flatnonzero(columns >= 0)
        for at in inside.tolist():
            # Up to the next profile it holds, for a fifth of a second at most: longer is a hole.
            following = columns[at + 1] if at + 1 < len(columns) else COLUMNS
            until = min(following, columns[at] + max(1, 200_000_000 // self._column_ns + 1))
            field[:, columns[at] : max(until, columns[at] + 1)] = self._profiles[at][1][:, None]
        return field

    def _axes(
        self, at_ns: int, ticks: Floats, shares: Floats, text: Callable[[float], str]
    ) -> Iterator[Batch]:
        depths = axis(0.0, self._length).ticks()
        depths = depths[depths <= self._length]
        seconds = axis(0.0, COLUMNS * self._column_ns / 1e9).ticks()
        seconds = seconds[seconds <= COLUMNS * self._column_ns / 1e9]
        places = [
            *((-16.0, ROWS * depth / self._length - LIFT) for depth in depths.tolist()),
            *((COLUMNS - s * 1e9 / self._column_ns, ROWS + 3.0) for s in seconds.tolist()),
            *((BAR_TO + 14.0, ROWS * (1 - share) - LIFT) for share in shares.tolist()),
            (0.0, -24.0),
            (COLUMNS / 2, ROWS + 18.0),
            (BAR_FROM + 4.0, -24.0),
        ]
        texts = (
            *(f"{depth:.0f}" for depth in depths.tolist()),
            *(f"−{s:.0f}" if s else "0" for s in seconds.tolist()),
            *map(text, ticks.tolist()),
            "depth, m",
            "s before the newest confirmed answer",
            self._unit,
        )
        yield Labels(f"{self._entity}/axes", at_ns, np.array(places), texts, (GREY,) * len(texts))
        frame = np.array([[0, 0], [COLUMNS, 0], [COLUMNS, ROWS], [0, ROWS], [0, 0]], dtype=np.float64)
        yield Strokes(f"{self._entity}/frame", at_ns, (frame,), (GREY,), 0.7)


def _png(shares: Floats) -> bytes:
    """The field in colours, and the scale of colours beside it."""
    picture = np.full((ROWS, BAR_TO), np.nan)
    picture[:, :COLUMNS] = shares
    picture[:, BAR_FROM:] = np.linspace(1.0, 0.0, ROWS)[:, None]
    known = np.isfinite(picture)
    indices = np.full(picture.shape, _UNKNOWN, dtype=np.uint8)
    indices[known] = 1 + np.clip(picture[known] * 254, 0, 254).round()
    image = Image.fromarray(indices, "P")
    colours = scale(np.linspace(0.0, 1.0, 255))
    image.putpalette([*GROUND[:3], *colours.ravel().tolist()])
    file = io.BytesIO()
    image.save(file, "PNG", compress_level=1)
    return file.getvalue()
