"""Values of a recorded state, each with its place in it: one that cannot be right is refused by name.

States come in files that others made: of another version, damaged, or meant to do harm.
"""

import reprlib
import sys
from collections.abc import Callable, Collection
from typing import TypeVar

_T = TypeVar("_T")


class Saved:
    """A value as `json.loads` gave it. Asked for what it is not, it raises ValueError with what is right."""

    def __init__(self, value: object, place: str) -> None:
        self._value = value
        self._place = place

    def __getitem__(self, key: str) -> "Saved":
        """What a table holds under a key."""
        table = self._table()
        if key not in table:
            raise ValueError(
                f"saved state: {self._under(key)} is not there: it is damaged, or of another version"
            )
        return Saved(table[key], self._under(key))

    def get(self, key: str, otherwise: object) -> "Saved":
        """The same, where an older version may have had no such key."""
        return Saved(self._table().get(key, otherwise), self._under(key))

    def items(self, keys: Collection[str]) -> list[tuple[str, "Saved"]]:
        """All that a table holds, under some of these keys."""
        table = self._table()
        if not table.keys() <= set(keys):
            raise self.wrong(f"a table with no keys but {', '.join(keys)}")
        return [(key, Saved(value, self._under(key))) for key, value in table.items()]

    def rows(self) -> list["Saved"]:
        """What a list holds."""
        if not isinstance(self._value, list):
            raise self.wrong("a list")
        return [Saved(value, f"{self._place}[{at}]") for at, value in enumerate(self._value)]

    def row(self, count: int) -> list["Saved"]:
        """The same of a list of so many."""
        rows = self.rows()
        if len(rows) != count:
            raise self.wrong(f"a list of {count}")
        return rows

    def whole(self, low: int, high: int) -> int:
        """A whole number between two, both included."""
        value = self._value
        if type(value) is not int or not low <= value <= high:  # of a bool it would be true as well
            raise self.wrong(f"a whole number from {low} to {high}")
        return value

    def number(self, low: float = -sys.float_info.max, high: float = sys.float_info.max) -> float:
        """A finite number between two, both included."""
        value = self._value
        if type(value) not in (int, float) or not low <= value <= high:  # type: ignore[operator]
            raise self.wrong(f"a number from {low:.12g} to {high:.12g}")
        return float(value)  # type: ignore[arg-type]

    def flag(self) -> bool:
        """True or false."""
        if not isinstance(self._value, bool):
            raise self.wrong("true or false")
        return self._value

    def or_none(self, read: Callable[["Saved"], _T]) -> _T | None:
        """What `read` makes of it; None for null."""
        return None if self._value is None else read(self)

    def wrong(self, right: str) -> ValueError:
        """The error to raise of it."""
        return ValueError(
            f"saved state: {self._place} holds {reprlib.repr(self._value)} where {right} is right"
        )

    def _under(self, key: str) -> str:
        return f"{self._place}.{key}"

    def _table(self) -> dict[str, object]:
        if not isinstance(self._value, dict):
            raise self.wrong("a table")
        return self._value
