"""A chart in a plane: an axis each way, ticks that people can read, curves between."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vsensor.view.batches import Batch, Colour, Floats, Labels, Strokes
from vsensor.view.palette import DIM, GREY

WIDTH, HEIGHT = 160.0, 90.0
"""Of the frame, in the plane's own units: the shape of a screen."""
BOUNDS = (-26.0, WIDTH + 8.0), (-24.0, HEIGHT + 27.0)
"""What of the plane is shown: there is room for the ticks' labels about the frame."""
LIFT = 5.0
"""Rerun hangs a label below its place by about so much."""


@dataclass(frozen=True, slots=True)
class Axis:
    """From `low` to `high`, with a tick at each multiple of `step`."""

    low: float
    high: float
    step: float

    def ticks(self) -> Floats:
        """Where the ticks are, ends included."""
        return np.asarray(
            np.arange(round(self.low / self.step), round(self.high / self.step) + 1) * self.step
        )

    def shares(self, values: Floats) -> Floats:
        """How far along the axis values are: 0 at its low end, 1 at the high."""
        return (values - self.low) / (self.high - self.low)

    def text(self, value: float) -> str:
        """A tick in as many digits as its step asks for."""
        return f"{value:.{max(0, -math.floor(math.log10(self.step) + 1e-9))}f}".replace("-", "−")


def axis(low: float, high: float, about: int = 4) -> Axis:
    """An axis that holds both, with about so many steps of 1, 2 or 5 times a power of ten."""
    span = max(high - low, 1e-9, 1e-6 * max(abs(low), abs(high)))
    power = 10 ** math.floor(math.log10(span / about))
    step = power * next(times for times in (1, 2, 5, 10) if times * power * about >= span * (1 - 1e-9))
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return Axis(first * step, max(last, first + 1) * step, step)


class Scale:
    """An axis that follows what is drawn, without trembling: it changes where they leave it or grow small."""

    def __init__(self, *always: float) -> None:
        self._always = always
        self._axis: Axis | None = None

    def follow(self, values: Floats) -> Axis:
        """The axis for these values; those that are not finite do not count."""
        known = [*self._always, *values[np.isfinite(values)].tolist()]
        low, high = min(known, default=0.0), max(known, default=1.0)
        last = self._axis
        if last is None or low < last.low or high > last.high or high - low < 0.4 * (last.high - last.low):
            self._axis = last = axis(low, high)
        return last


class Chart:
    """One entity's frame; curves are drawn into it by `curve`, in the units of its axes."""

    def __init__(self, entity: str, x_title: str, y_title: str, *, y_down: bool = False) -> None:
        self.entity = entity
        self._titles = x_title, y_title
        self._y_down = y_down
        self._drawn: tuple[Axis, Axis] | None = None
        self._x = self._y = Axis(0, 1, 1)

    def frame(self, time_ns: int, x: Axis, y: Axis) -> Iterator[Batch]:
        """Set the axes, and draw them where they are new."""
        self._x, self._y = x, y
        if self._drawn == (x, y):
            return
        self._drawn = x, y
        yield self._grid(time_ns, x, y)
        x_places = self.places(x.ticks(), np.full(len(x.ticks()), y.high if self._y_down else y.low))
        y_places = self.places(np.full(len(y.ticks()), x.low), y.ticks())
        title_places = np.array([[WIDTH / 2, HEIGHT + 13], [0.0, -21.0]])
        places = np.vstack([np.add(x_places, [0, 2]), np.subtract(y_places, [11, LIFT]), title_places])
        texts = (*map(x.text, x.ticks().tolist()), *map(y.text, y.ticks().tolist()), *self._titles)
        yield Labels(f"{self.entity}/axes", time_ns, places, texts, (GREY,) * len(texts))

    def _grid(self, time_ns: int, x: Axis, y: Axis) -> Batch:
        across = [np.array([[0.0, at], [WIDTH, at]]) for at in self._down(y.shares(y.ticks())).tolist()]
        down = [np.array([[at, 0.0], [at, HEIGHT]]) for at in (x.shares(x.ticks()) * WIDTH).tolist()]
        lines = (*across, *down)
        return Strokes(f"{self.entity}/axes/grid", time_ns, lines, (DIM,) * len(lines), 0.7)

    def places(self, xs: Floats, ys: Floats) -> Floats:
        """Where points of the chart are in its plane, shape (n, 2)."""
        return np.stack([self._x.shares(xs) * WIDTH, self._down(self._y.shares(ys))], axis=1)

    def curve(
        self, name: str, time_ns: int, xs: Floats, ys: Floats, colour: Colour, width: float = 2.0
    ) -> Batch:
        """A curve through points, shape (n,) each; what is not finite is left out."""
        known = np.isfinite(xs) & np.isfinite(ys)
        line = self.places(xs[known], ys[known])
        lines = (line,) if len(line) > 1 else ()
        return Strokes(f"{self.entity}/{name}", time_ns, lines, (colour,) * len(lines), width)

    def legend(self, time_ns: int, entries: Sequence[tuple[str, Colour]]) -> Batch:
        """Names of curves in their colours, at the right above."""
        places = np.array([[WIDTH - 24.0, 6.0 + 8.0 * row] for row in range(len(entries))])
        texts, colours = zip(*entries, strict=True)
        return Labels(f"{self.entity}/legend", time_ns, places, texts, colours)

    def _down(self, shares: Floats) -> Floats:
        return HEIGHT * (shares if self._y_down else 1 - shares)
