"""What the stream hands to the screen, in words of our own: only the screen knows Rerun."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Colour = tuple[int, int, int, int]
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Look:
    """How the line of one entity is drawn."""

    entity: str
    name: str
    colour: Colour
    width: float


@dataclass(frozen=True, slots=True)
class BandLook:
    """How a line with a band about it is drawn."""

    entity: str
    name: str
    colour: Colour
    width: float


@dataclass(frozen=True, slots=True)
class DotLook:
    """How single points of a plot are drawn."""

    entity: str
    name: str
    colour: Colour
    size: float


@dataclass(frozen=True, slots=True)
class LaneLook:
    """The colour of a lane in each of its states."""

    entity: str
    colours: Mapping[str, Colour]


@dataclass(frozen=True, slots=True)
class Points:
    """Rows of one entity's line: times_ns and values of shape (rows,); NaN is a hole."""

    entity: str
    times_ns: NDArray[np.int64]
    values: Floats


@dataclass(frozen=True, slots=True)
class Measured:
    """The same with half the width of the band about each value, shape (rows,)."""

    entity: str
    times_ns: NDArray[np.int64]
    values: Floats
    bands: Floats


@dataclass(frozen=True, slots=True)
class Lane:
    """The state that something is in from its time on, drawn as a bar; no text for none."""

    entity: str
    time_ns: int
    state: str


@dataclass(frozen=True, slots=True)
class LogLine:
    """One line in the list of events."""

    entity: str
    time_ns: int
    level: str
    text: str


@dataclass(frozen=True, slots=True)
class Page:
    """A page of text (Markdown), valid from its time on."""

    entity: str
    time_ns: int
    text: str


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture (PNG), valid from its time on; its pixels are the coordinates of what is drawn over it."""

    entity: str
    time_ns: int
    png: bytes


@dataclass(frozen=True, slots=True)
class Strokes:
    """Lines in a plane (y down) or in space, from their time on: each (n, 2) or (n, 3), with its colour."""

    entity: str
    time_ns: int
    lines: tuple[Floats, ...]
    colours: tuple[Colour, ...]
    width: float


@dataclass(frozen=True, slots=True)
class Labels:
    """Texts at places in a plane or in space, shape (n, 2) or (n, 3), valid from their time on."""

    entity: str
    time_ns: int
    places: Floats
    texts: tuple[str, ...]
    colours: tuple[Colour, ...]


Batch = (
    Look
    | BandLook
    | DotLook
    | LaneLook
    | Points
    | Measured
    | Lane
    | LogLine
    | Page
    | Picture
    | Strokes
    | Labels
)
