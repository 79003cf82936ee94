"""What a benchmark tells: a table of figures, for people to read and for programs to keep."""

from dataclasses import dataclass

Cell = str | int | float | None
"""None where a figure could not be had."""


@dataclass(frozen=True, slots=True)
class Table:
    """Figures under headings that name their units, one row a case, and what must be known beside them."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """The same for JSON: each row by its headings."""
        rows = [dict(zip(self.columns, row, strict=True)) for row in self.rows]
        return {"title": self.title, "rows": rows, "notes": list(self.notes)}
