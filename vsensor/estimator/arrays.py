"""A state's arrays by name: to be kept, and taken up again."""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from vsensor.estimator.state import State

LEARNED = ("scores", "learned", "tuning", "rock_square", "level", "resolution", "lasts", "white", "noisier")
"""What stays when the waves are lost: these, and all within them."""


def flat(state: State, wanted: Collection[str] = State._fields) -> dict[str, NDArray[np.generic]]:
    """Copies of a state's arrays by name, those of an inner tuple as `learned.NAME`; of the wanted fields."""
    named = {}
    for name in wanted:
        value = getattr(state, name)
        if isinstance(value, np.ndarray):
            named[name] = value.copy()
        else:
            named |= {f"{name}.{inner}": array.copy() for inner, array in value._asdict().items()}
    return named


def fill(state: State, saved: Mapping[str, NDArray[np.generic]]) -> None:
    """Copy saved arrays into a state. Raises ValueError where one does not fit."""
    for name, array in saved.items():
        place: object = state
        for part in name.split("."):
            place = getattr(place, part)
        if not isinstance(place, np.ndarray) or place.shape != array.shape or place.dtype != array.dtype:
            asked = f"{place.dtype}{place.shape}" if isinstance(place, np.ndarray) else "nothing"
            raise ValueError(
                f"saved state: {name} is {array.dtype}{array.shape}, the configuration asks for {asked}"
            )
        place[...] = array


def is_learned(name: str) -> bool:
    """Whether an array of this name (see `flat`) stays when the waves are lost."""
    return name.split(".")[0] in LEARNED
