"""Colours: of things, such as the colour-blind tell apart too; of numbers, a scale from dark to bright."""

import numpy as np
from numpy.typing import NDArray

from vsensor.view.batches import Colour, Floats

# Okabe and Ito's palette (jfly.uni-koeln.de/color).
GREY: Colour = (150, 150, 150, 255)
WHITE: Colour = (235, 235, 235, 255)
DIM: Colour = (90, 94, 98, 255)
BLUE: Colour = (86, 180, 233, 255)
ORANGE: Colour = (230, 159, 0, 255)
PINK: Colour = (204, 121, 167, 255)
GREEN: Colour = (0, 158, 115, 255)
YELLOW: Colour = (240, 228, 66, 255)
VERMILION: Colour = (213, 94, 0, 255)
DEEP_RED: Colour = (160, 45, 45, 255)
GROUND: Colour = (13, 16, 17, 255)
"""As behind Rerun's own views."""

# Viridis (Smith and van der Walt 2015) at nine places, evenly brighter from the first to the last.
_SCALE = np.array(
    [
        (68, 1, 84),
        (71, 44, 122),
        (59, 81, 139),
        (44, 113, 142),
        (33, 144, 141),
        (39, 173, 129),
        (92, 200, 99),
        (170, 220, 50),
        (253, 231, 37),
    ],
    dtype=np.float64,
)


def scale(shares: Floats) -> NDArray[np.uint8]:
    """Colours of numbers from 0 (dark) to 1 (bright), shape (n,); returns (n, 3). Beyond, the ends' own."""
    at = np.clip(shares, 0.0, 1.0) * (len(_SCALE) - 1)
    steps = np.arange(len(_SCALE))
    channels = [np.interp(at, steps, _SCALE[:, channel]) for channel in range(3)]
    return np.stack(channels, axis=1).round().astype(np.uint8)


def opaque(colours: NDArray[np.uint8]) -> tuple[Colour, ...]:
    """The same as colours of batches."""
    return tuple((r, g, b, 255) for r, g, b in colours.tolist())
