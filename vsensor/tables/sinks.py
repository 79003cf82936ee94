"""Where a table goes: a file of CSV, Parquet or NumPy, some rows at a time."""

import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Protocol

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.csv as arrow_csv
import pyarrow.parquet as arrow_parquet

Columns = Mapping[str, npt.NDArray[Any]]

_TEXT = np.dtype("<U16")
"""As NumPy keeps a column of words: the longest that we write has 9 letters."""
_COPIED = 1 << 20


class Sink(Protocol):
    """A file that is being written. Raises OSError where it cannot be."""

    def __init__(self, path: Path, names: Sequence[str]) -> None: ...

    def put(self, columns: Columns) -> None:
        """Add rows."""

    def close(self) -> None:
        """Complete the file."""

    def abandon(self) -> None:
        """Let go of it, as it is."""


class Csv:
    """NaN and None as nothing."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        self._file = path.open("wb")
        self._file.write((",".join(names) + "\n").encode())  # Arrow would put the names in quotes

    def put(self, columns: Columns) -> None:
        """Add rows."""
        options = arrow_csv.WriteOptions(include_header=False, quoting_style="none")
        arrow_csv.write_csv(_arrow(columns), self._file, options)

    def close(self) -> None:
        """Complete the file."""
        self._file.close()

    abandon = close


class Parquet:
    """NaN and None as null; a group of rows for each `put`."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        self._file = path.open("wb")
        self._names = names
        self._writer: arrow_parquet.ParquetWriter | None = None

    def put(self, columns: Columns) -> None:
        """Add rows."""
        table = _arrow(columns)
        if self._writer is None:
            words = [field.name for field in table.schema if pa.types.is_string(field.type)]
            # A dictionary of numbers that hardly repeat would only cost time.
            self._writer = arrow_parquet.ParquetWriter(self._file, table.schema, use_dictionary=words)
        self._writer.write_table(table)

    def close(self) -> None:
        """Complete the file; without rows it has the columns all the same."""
        if self._writer is None:
            self.put({name: np.empty(0) for name in self._names})
        self.abandon()

    def abandon(self) -> None:
        """Let go of it, as it is."""
        if self._writer is not None:
            self._writer.close()
        self._file.close()


class Npz:
    """An array a column, in a zip file as `numpy.savez` writes it; the columns wait in files of their own."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        self._file = path.open("wb")
        self._spools: dict[str, IO[bytes]] = {
            name: tempfile.TemporaryFile(dir=path.parent)  # noqa: SIM115, closed in abandon
            for name in names
        }
        self._kinds: dict[str, np.dtype[Any]] = {}
        self._rows = 0

    def put(self, columns: Columns) -> None:
        """Add rows."""
        for name, spool in self._spools.items():
            column = columns[name]
            if column.dtype.kind in "OU":
                column = np.where(column == None, "", column).astype(_TEXT)  # noqa: E711, of each element
            self._kinds[name] = column.dtype
            spool.write(np.ascontiguousarray(column).tobytes())
        self._rows += len(column)

    def close(self) -> None:
        """Complete the file."""
        with zipfile.ZipFile(self._file, "w", allowZip64=True) as archive:
            for name, spool in self._spools.items():
                kind = self._kinds.get(name, np.dtype(np.float64))
                head = {"descr": kind.str, "fortran_order": False, "shape": (self._rows,)}
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array_header_1_0(member, head)
                    spool.seek(0)
                    while part := spool.read(_COPIED):
                        member.write(part)
        self.abandon()

    def abandon(self) -> None:
        """Let go of it, as it is."""
        for spool in self._spools.values():
            spool.close()
        self._file.close()


SINKS: Mapping[str, type[Sink]] = {".csv": Csv, ".parquet": Parquet, ".npz": Npz}
"""By the ending of the file's name."""


def _arrow(columns: Columns) -> pa.Table:
    return pa.table({name: pa.array(column, from_pandas=True) for name, column in columns.items()})
