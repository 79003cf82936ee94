"""What looks odd in a table that is read all the same: whoever reads it is told."""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from vsensor.tables.cells import Floats

_NOTHING = (-999.25, -999.0, -9999.0)
"""As loggers write that there is no value; but it may have been measured."""


class Findings:
    """Gathered from the columns of a table, piece by piece."""

    def __init__(self) -> None:
        self._known: Counter[str] = Counter()
        self._nothing: Counter[tuple[str, float]] = Counter()

    def look(self, column: str, values: Floats) -> None:
        """Take in some of a column, as it is written, NaN where there is no value."""
        self._known[column] += int(np.count_nonzero(~np.isnan(values)))
        for nothing in _NOTHING:
            if count := int(np.count_nonzero(values == nothing)):
                self._nothing[column, nothing] += count

    def empty(self) -> list[str]:
        """The columns without any value."""
        return [column for column, count in self._known.items() if not count]

    def words(self) -> Iterator[str]:
        """Yield a sentence for each."""
        for column in self.empty():
            yield f"{column} has no value at all"
        for (column, value), count in self._nothing.items():
            cells = "1 cell" if count == 1 else f"{count} cells"
            are = "is" if count == 1 else "are"
            yield f"{cells} of {column} {are} {value:g}: if that stands for no value, --null {value:g}"
