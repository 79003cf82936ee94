"""Tables of NumPy: an array a column in a zip file, as `numpy.savez` writes it."""

import zipfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

import numpy as np
import pyarrow as pa

from vsensor.errors import InputError
from vsensor.tables.source import DAMAGED, Source, check_columns

_ROWS = 100_000
_DAMAGED = (*DAMAGED, ValueError, EOFError, zipfile.BadZipFile, NotImplementedError)
"""What is raised of files that are none: the last by `zipfile`, where one is packed as it cannot unpack."""
_ENDING = ".npy"


class Npz(Source):
    """Columns of equal length, read side by side; they may be compressed."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def columns(self) -> list[str]:
        """The names of all columns."""
        try:
            with zipfile.ZipFile(self.path) as archive:
                return [name.removesuffix(_ENDING) for name in archive.namelist()]
        except _DAMAGED as error:
            raise self._none(error) from error

    def batches(self, names: Mapping[str, str]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, a batch of rows at a time."""
        check_columns(self.path, names, self.columns())
        try:
            with zipfile.ZipFile(self.path) as archive, ExitStack() as opened:
                columns = [_Column(opened.enter_context(archive.open(f"{name}{_ENDING}"))) for name in names]
                lengths = {name: column.rows for name, column in zip(names, columns, strict=True)}
                if len(set(lengths.values())) != 1:
                    raise ValueError(f"its columns are not of one length: {lengths}")
                for _ in range(0, columns[0].rows, _ROWS):
                    yield pa.RecordBatch.from_arrays([column.next() for column in columns], list(names))
        except _DAMAGED as error:
            raise self._none(error) from error

    def _none(self, error: Exception) -> InputError:
        return InputError(f"{self.path}: is no NumPy table (npz): {error}")


class _Column:
    """One array of a file, read from its begin on; ValueError for what is no column."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        version = np.lib.format.read_magic(file)
        read_head: Any = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }.get(version)
        if read_head is None:
            raise ValueError(f"it is of NumPy's version {version}")
        shape, _, self._kind = read_head(file)
        if len(shape) != 1 or self._kind.hasobject or not self._kind.itemsize:
            raise ValueError(f"a column is of shape {shape} and type {self._kind}")
        self.rows = self._left = shape[0]

    def next(self) -> pa.Array:
        """The next rows, or those that are left; NaN as it is."""
        count = min(_ROWS, self._left)
        self._left -= count
        data = self._file.read(count * self._kind.itemsize)
        return pa.array(np.frombuffer(data, self._kind, count))
