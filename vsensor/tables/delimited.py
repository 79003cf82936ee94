"""Tables of CSV, as loggers and spreadsheets of any country write them."""

import csv
import re
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any, TextIO

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as arrow_csv

from vsensor.errors import InputError
from vsensor.tables.source import DAMAGED, PLAIN_HEAD, Head, check_columns

_DELIMITERS = (",", ";", "\t")
_TOLD = re.compile(r"sep=([,;\t|:])\r?\n?", re.IGNORECASE)
"""Excel's first line, by which it knows again what parts the columns."""
_FAR_DOWN = 200
"""Lines among which a header is looked for that does not come first."""


class Csv:
    """Columns apart by what a first line says (`sep=;`), else by commas, semicolons or tabs, all as text.

    Of the three it is what parts the header into most. Where it is no comma, numbers may have decimal commas:
    what is yielded has points.
    """

    def __init__(self, path: Path, head: Head = PLAIN_HEAD) -> None:
        self.path = path
        with self._opened(0) as file:
            told = _TOLD.fullmatch(file.readline(len("sep=;\r\n")))
        self._delimiters = (told[1],) if told else _DELIMITERS
        self._skipped = max(head.skipped, 1 if told else 0)
        """Lines before the header."""
        self._units = 1 if head.units else 0
        """Rows between the header and what was measured."""

    def columns(self) -> list[str]:
        """The names of all columns."""
        return [name.strip() for name in self._head()[1]]

    def units(self) -> Mapping[str, str]:
        """What stands under the names, without brackets, where the file has a line of units."""
        _, header, below = self._head()
        told = zip(header, below, strict=False) if self._units else ()
        return {name.strip(): unit for name, cell in told if (unit := cell.strip(" []()"))}

    def batches(self, names: Mapping[str, str]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, a batch of rows at a time."""
        delimiter, header = self._head()[:2]
        self._check(names)
        written = {name.strip(): name for name in header}
        columns = [written[name] for name in names]
        ragged: list[Any] = []

        def refuse(row: Any) -> str:
            ragged.append(row)
            return "error"

        # As text, to be read as numbers here: Arrow's own message would not name the line.
        options = arrow_csv.ConvertOptions(
            include_columns=columns,
            column_types=dict.fromkeys(columns, pa.string()),
            null_values=[""],
            strings_can_be_null=True,
        )
        try:
            batches = arrow_csv.open_csv(
                self.path,
                read_options=arrow_csv.ReadOptions(
                    skip_rows=self._skipped,
                    skip_rows_after_names=self._units,
                    use_threads=False,  # else rows are not counted
                ),
                parse_options=arrow_csv.ParseOptions(delimiter=delimiter, invalid_row_handler=refuse),
                convert_options=options,
            )
            points = _Points(self) if delimiter != "," else None
            for batch in batches:
                named = batch.rename_columns(list(names))
                yield points.plain(named) if points else named
        except DAMAGED as error:
            raise self._damage(error, ragged) from error

    def place(self, row: int) -> str:
        """The line in which a row stands."""
        with self._opened(self._skipped) as file:
            reader = csv.reader(file)
            # With the header, without blank lines.
            for _ in islice(filter(None, reader), 1 + self._units + row + 1):
                pass
            return f"line {self._skipped + reader.line_num}"

    def _damage(self, error: Exception, ragged: list[Any]) -> InputError:
        if "UTF8" in str(error):
            return _other_letters(self.path)
        if not ragged or ragged[-1].number is None:
            return InputError(f"{self.path}: is no CSV table: {error}")
        bad = ragged[-1]
        place = self.place(bad.number - 2 - self._skipped - self._units)
        return InputError(
            f"{self.path}, {place}: has {bad.actual_columns} values, "
            f"where the header names {bad.expected_columns}"
        )

    def _check(self, names: Mapping[str, str]) -> None:
        present = self.columns()
        if not set(names) <= set(present) and any("\ufffd" in name for name in present):
            raise _other_letters(self.path)
        check_columns(self.path, names, present, self._header_below(set(names)))

    def _header_below(self, names: set[str]) -> str:
        """What to do where a line further down names the columns."""
        with self._opened(0) as file:
            for number, line in enumerate(islice(file, _FAR_DOWN)):
                for delimiter in self._delimiters:
                    if names <= {cell.strip(' "\r\n') for cell in line.split(delimiter)}:
                        return f"line {number + 1} has all of them: vsensor import --skip-lines {number}"
        return ""

    def _head(self) -> tuple[str, list[str], list[str]]:
        """What parts the columns, their names, and what stands in the row below."""
        try:
            found = []
            for delimiter in self._delimiters:
                with self._opened(self._skipped) as file:
                    rows = filter(None, csv.reader(file, delimiter=delimiter))
                    found.append((delimiter, next(rows), next(rows, [])))
            return max(found, key=lambda told: len(told[1]))
        except StopIteration as error:
            raise InputError(f"{self.path}: is empty: a header and rows were expected") from error
        except csv.Error as error:
            raise InputError(f"{self.path}: is no CSV table: {error}") from error

    def _opened(self, skipped: int) -> TextIO:
        file = self.path.open(encoding="utf-8-sig", errors="replace", newline="")
        for _ in islice(file, skipped):
            pass
        return file


class _Points:
    """Decimal commas made points, where a column has the one or the other throughout."""

    def __init__(self, source: Csv) -> None:
        self._source = source
        self._rows = 0
        self._marks: dict[str, str] = {}
        """What parts the decimals of each column, as far as it is known."""

    def plain(self, batch: pa.RecordBatch) -> pa.RecordBatch:
        """The same with points; InputError where a column has both."""
        columns = [self._column(name, batch.column(name)) for name in batch.schema.names]
        self._rows += batch.num_rows
        return pa.RecordBatch.from_arrays(columns, batch.schema.names)

    def _column(self, name: str, text: pa.Array) -> pa.Array:
        for mark in ".,":  # so that of both in one batch the comma is named
            parted = pc.match_substring_regex(text, rf"^\s*[+-]?\d*[{mark}]\d+(?:[eE][+-]?\d+)?\s*$")
            row = pc.index(parted, True).as_py()
            if row >= 0 and self._marks.setdefault(name, mark) != mark:
                raise self._both(name, row, text[row].as_py())
        if self._marks.get(name) != ",":
            return text
        return pc.replace_substring_regex(text, r"^(\s*[+-]?\d*),(\d+(?:[eE][+-]?\d+)?\s*)$", r"\1.\2")

    def _both(self, name: str, row: int, cell: str) -> InputError:
        place, others = self._source.place(self._rows + row), "comma" if "." in cell else "point"
        return InputError(
            f"{self._source.path}, {place}: {name} is {cell!r}, where others of the column have a {others}: "
            "marks between thousands are not read"
        )


def _other_letters(path: Path) -> InputError:
    return InputError(f"{path}: is not UTF-8: save it as UTF-8 (in Excel: CSV UTF-8)")
