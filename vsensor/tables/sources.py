"""Where a table comes from: CSV, Parquet, Arrow or NumPy, a batch of rows at a time."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as arrow_parquet

from vsensor.errors import ConfigError, InputError
from vsensor.tables.delimited import Csv
from vsensor.tables.npz import Npz
from vsensor.tables.source import DAMAGED, PLAIN_HEAD, Head, Source, check_columns

_ARROW_FILE = b"ARROW1"
"""What a file begins with, and a stream does not."""


class Parquet(Source):
    """Columns of any type of numbers, text or time."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def columns(self) -> list[str]:
        """The names of all columns."""
        with self._opened() as file:
            return list(file.schema_arrow.names)

    def batches(self, names: Mapping[str, str]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, a batch of rows at a time."""
        check_columns(self.path, names, self.columns())
        with self._opened() as file:
            yield from file.iter_batches(columns=list(names))

    @contextmanager
    def _opened(self) -> Iterator[Any]:
        try:
            with arrow_parquet.ParquetFile(self.path) as file:
                yield file
        except DAMAGED as error:
            raise InputError(f"{self.path}: is no Parquet table: {error}") from error


class Arrow(Parquet):
    """Arrow's own formats: the file, which is Feather's second version, and the stream."""

    def columns(self) -> list[str]:
        """The names of all columns."""
        with self._opened() as file:
            return list(file.schema.names)

    def batches(self, names: Mapping[str, str]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, a batch of rows at a time."""
        check_columns(self.path, names, self.columns())
        with self._opened() as file:
            if isinstance(file, pa.ipc.RecordBatchFileReader):
                batches = (file.get_batch(number) for number in range(file.num_record_batches))
            else:
                batches = iter(file)
            for batch in batches:
                yield batch.select(list(names))

    @contextmanager
    def _opened(self) -> Iterator[Any]:
        try:
            with pa.memory_map(str(self.path)) as mapped:
                is_file = mapped.read(len(_ARROW_FILE)) == _ARROW_FILE
                mapped.seek(0)
                yield pa.ipc.open_file(mapped) if is_file else pa.ipc.open_stream(mapped)
        except DAMAGED as error:
            raise InputError(f"{self.path}: is no Arrow table (Feather 2, or a stream): {error}") from error


SOURCES: dict[str, Callable[[Path], Source]] = {
    ".csv": Csv,
    ".parquet": Parquet,
    ".feather": Arrow,
    ".arrow": Arrow,
    ".arrows": Arrow,
    ".npz": Npz,
}
"""By the ending of the file's name."""


def source_of(path: Path, head: Head = PLAIN_HEAD) -> Source:
    """The source of a table's rows; ConfigError for another kind of file, InputError for none at all."""
    kind = path.suffix.lower()
    if kind not in SOURCES:
        raise ConfigError(f"{path}: a table's name must end in {' or '.join(SOURCES)}")
    try:
        path.open("rb").close()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    if kind == ".csv":
        return Csv(path, head)
    if head != PLAIN_HEAD:
        raise ConfigError(f"{path}: only a .csv has lines before its header, or one of units")
    return SOURCES[kind](path)
