"""What is seen in a picture of the view."""

import numpy as np
from numpy.typing import NDArray

from vsensor.view.batches import Colour
from vsensor.view.palette import BLUE, GREY, ORANGE, PINK

Pixels = NDArray[np.uint8]
"""Shape (height, width, 3)."""

LEAST_PIXELS = 25
"""A curve of some width has many more."""


def pixels_of(picture: Pixels, colour: Colour) -> int:
    """How many pixels are of a colour, as near as smoothing leaves them."""
    return int((np.abs(picture.astype(int) - colour[:3]).max(axis=2) <= 8).sum())


def shows_curves(picture: Pixels) -> bool:
    """Whether bit (confirmed, now, foretold) and surface are drawn, below the large figures."""
    plots = picture[picture.shape[0] // 5 :, : picture.shape[1] * 7 // 10]
    return all(pixels_of(plots, colour) >= LEAST_PIXELS for colour in (BLUE, ORANGE, PINK, GREY))
