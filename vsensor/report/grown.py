"""A column that is added to piece by piece."""

from typing import Any

import numpy as np
import numpy.typing as npt


class Grown:
    """Numbers of one kind in one array, which grows where it lies.

    Pieces held until all are there would take as much again, for what they leave behind is in pieces too.
    """

    def __init__(self, kind: type[np.generic]) -> None:
        self._array: npt.NDArray[Any] = np.empty(0, kind)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, values: npt.NDArray[Any]) -> None:
        """Add n numbers behind those there are."""
        end = self._count + len(values)
        if end > len(self._array):
            self._array.resize(end + end // 8, refcheck=False)  # nobody has a view of it yet
        self._array[self._count : end] = values
        self._count = end

    def whole(self) -> npt.NDArray[Any]:
        """All numbers, shape (n,); nothing can be added any more."""
        self._array.resize(self._count, refcheck=False)
        return self._array
