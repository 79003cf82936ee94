"""Where a table comes from: CSV, Parquet or Arrow, a batch of rows at a time."""

import csv
import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, TextIO

import pyarrow as pa
import pyarrow.csv as arrow_csv
import pyarrow.parquet as arrow_parquet

from vsensor.errors import ConfigError, InputError

_DAMAGED = (pa.ArrowException, OSError, UnicodeDecodeError)
"""What Arrow raises where a file is not what it should be."""
_DELIMITERS = (",", ";", "\t")
_TOLD = re.compile(r"sep=([,;\t|:])\r?\n?", re.IGNORECASE)
"""Excel's first line, by which it knows again what parts the columns."""
_ARROW_FILE = b"ARROW1"
"""What a file begins with, and a stream does not."""


class Source(Protocol):
    """A file with named columns."""

    path: Path

    def __init__(self, path: Path) -> None: ...

    def batches(self, names: Sequence[str]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, a batch of rows at a time."""

    def place(self, row: int) -> str:
        """Where a row (from 0) stands, as its reader would look for it."""


class Csv:
    """Columns apart by what a first line says (`sep=;`), else by commas, semicolons or tabs, all as text.

    Of the three it is what parts the header into most.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._opened() as file:
            told = _TOLD.fullmatch(file.readline(len("sep=;\r\n")))
        self._delimiters = (told[1],) if told else _DELIMITERS
        self._skipped = 1 if told else 0
        """Lines before the header."""

    def batches(self, names: Sequence[str]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, a batch of rows at a time."""
        delimiter, header = self._header()
        present = [name.strip() for name in header]
        if not set(names) <= set(present) and any("\ufffd" in name for name in present):
            raise _other_letters(self.path)
        _check_columns(self.path, names, present)
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
                    use_threads=False,  # else rows are not counted
                ),
                parse_options=arrow_csv.ParseOptions(delimiter=delimiter, invalid_row_handler=refuse),
                convert_options=options,
            )
            yield from (batch.rename_columns(list(names)) for batch in batches)
        except _DAMAGED as error:
            if "UTF8" in str(error):
                raise _other_letters(self.path) from error
            if not ragged or ragged[-1].number is None:
                raise InputError(f"{self.path}: is no CSV table: {error}") from error
            bad = ragged[-1]
            place = self.place(bad.number - 2 - self._skipped)
            raise InputError(
                f"{self.path}, {place}: has {bad.actual_columns} values, "
                f"where the header names {bad.expected_columns}"
            ) from error

    def _header(self) -> tuple[str, list[str]]:
        """What parts the columns, and their names."""
        try:
            found = []
            for delimiter in self._delimiters:
                with self._opened() as file:
                    reader = csv.reader(islice(file, self._skipped, None), delimiter=delimiter)
                    found.append((delimiter, next(filter(None, reader))))
            return max(found, key=lambda told: len(told[1]))
        except StopIteration as error:
            raise InputError(f"{self.path}: is empty: a header and rows were expected") from error
        except csv.Error as error:
            raise InputError(f"{self.path}: is no CSV table: {error}") from error

    def place(self, row: int) -> str:
        """The line in which a row stands."""
        with self._opened() as file:
            reader = csv.reader(file)
            for _ in islice(
                filter(None, reader), self._skipped + row + 2
            ):  # with the header, without blank lines
                pass
            return f"line {reader.line_num}"

    def _opened(self) -> TextIO:
        return self.path.open(encoding="utf-8-sig", errors="replace", newline="")


class Parquet:
    """Columns of any type of numbers, text or time."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def batches(self, names: Sequence[str]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, a batch of rows at a time."""
        try:
            with arrow_parquet.ParquetFile(self.path) as file:
                _check_columns(self.path, names, file.schema_arrow.names)
                yield from file.iter_batches(columns=list(names))
        except _DAMAGED as error:
            raise InputError(f"{self.path}: is no Parquet table: {error}") from error

    def place(self, row: int) -> str:
        """The number of a row."""
        return f"row {row + 1}"


class Arrow(Parquet):
    """Arrow's own formats: the file, which is Feather's second version, and the stream."""

    def batches(self, names: Sequence[str]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, a batch of rows at a time."""
        try:
            with pa.memory_map(str(self.path)) as mapped:
                if mapped.read(len(_ARROW_FILE)) == _ARROW_FILE:
                    yield from self._of_file(pa.ipc.open_file(mapped), names)
                else:
                    mapped.seek(0)
                    yield from self._of_stream(pa.ipc.open_stream(mapped), names)
        except _DAMAGED as error:
            raise InputError(f"{self.path}: is no Arrow table (Feather 2, or a stream): {error}") from error

    def _of_file(self, file: Any, names: Sequence[str]) -> Iterator[pa.RecordBatch]:
        _check_columns(self.path, names, file.schema.names)
        for number in range(file.num_record_batches):
            yield file.get_batch(number).select(names)

    def _of_stream(self, stream: Any, names: Sequence[str]) -> Iterator[pa.RecordBatch]:
        _check_columns(self.path, names, stream.schema.names)
        for batch in stream:
            yield batch.select(names)


SOURCES: dict[str, type[Source]] = {
    ".csv": Csv,
    ".parquet": Parquet,
    ".feather": Arrow,
    ".arrow": Arrow,
    ".arrows": Arrow,
}
"""By the ending of the file's name."""


def source_of(path: Path) -> Source:
    """The source of a table's rows; ConfigError for another kind of file, InputError for none at all."""
    kind = path.suffix.lower()
    if kind not in SOURCES:
        raise ConfigError(f"{path}: a table's name must end in {' or '.join(SOURCES)}")
    try:
        path.open("rb").close()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    return SOURCES[kind](path)


def _other_letters(path: Path) -> InputError:
    return InputError(f"{path}: is not UTF-8: save it as UTF-8 (in Excel: CSV UTF-8)")


def _check_columns(path: Path, names: Sequence[str], present: list[str]) -> None:
    for name in names:
        if present.count(name) != 1:
            fault = "no column" if name not in present else "more than one column"
            there = ", ".join(map(repr, present))
            raise InputError(f"{path}: has {fault} {name!r}; its columns are: {there:.300}")
