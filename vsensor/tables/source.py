"""What every kind of table gives its reader."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import pyarrow as pa

from vsensor.errors import InputError

DAMAGED = (pa.ArrowException, OSError, UnicodeDecodeError)
"""What Arrow raises where a file is not what it should be."""


@dataclass(frozen=True)
class Head:
    """What a CSV file has about its header: lines before it, and maybe one of units behind it."""

    skipped: int = 0
    units: bool = False


PLAIN_HEAD = Head()


class Source(Protocol):
    """A file with named columns."""

    path: Path

    def columns(self) -> list[str]:
        """The names of all columns."""

    def batches(self, names: Mapping[str, str]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, each given with the option that names it, a batch of rows at a time."""

    def units(self) -> Mapping[str, str]:
        """The unit of each column whose unit the file tells; of most kinds none does."""
        return {}

    def place(self, row: int) -> str:
        """Where a row (from 0) stands, as its reader would look for it."""
        return f"row {row + 1}"


def check_columns(path: Path, names: Mapping[str, str], present: Sequence[str], hint: str = "") -> None:
    """Raise InputError for what is not there, or more than once: with what is there, and what would help."""
    for name, option in names.items():
        if present.count(name) != 1:
            fault = "no column" if name not in present else "more than one column"
            there = ", ".join(map(repr, present))
            helps = "" if name in present else f": {hint or f'vsensor import {option} names another'}"
            raise InputError(f"{path}: has {fault} {name!r}; its columns are: {there:.300}{helps}")
