"""What the stream hands to the screen, in words of our own: only the screen knows Rerun."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Colour = tuple[int, int, int, int]


@dataclass(frozen=True, slots=True)
class Look:
    """How the lines of one entity are drawn; an entity may hold several, such as both edges of a band."""

    entity: str
    names: tuple[str, ...]
    colour: Colour
    width: float


@dataclass(frozen=True, slots=True)
class LaneLook:
    """The colour of a lane in each of its states."""

    entity: str
    colours: Mapping[str, Colour]


@dataclass(frozen=True, slots=True)
class Points:
    """Rows of one entity's lines: times_ns of shape (rows,), values of shape (rows, lines); NaN is a hole."""

    entity: str
    times_ns: NDArray[np.int64]
    values: NDArray[np.float64]


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


Batch = Look | LaneLook | Points | Lane | LogLine | Page
