"""Tables: what a rig measured, read from CSV or Parquet; what the sensor made of it, written."""

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as arrow_csv
import pyarrow.parquet as arrow_parquet

from vsensor.errors import ConfigError, InputError
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.units import factor

Floats = npt.NDArray[np.float64]

SURFACE_UNITS = {"time_s": "s", "motor_torque_nm": "N*m", "motor_speed_rad_s": "rad/s"}
"""The columns of a surface table, and the unit that each is in unless told otherwise."""

ESTIMATE_FIELDS = {
    "time_s": "time_ns",
    "confirmed_time_s": "confirmed_time_ns",
    "confirmed_speed_rad_s": "confirmed_bit_speed_rad_s",
    "confirmed_speed_std_rad_s": "confirmed_bit_speed_std_rad_s",
    "confirmed_torque_nm": "confirmed_bit_torque_nm",
    "confirmed_torque_std_nm": "confirmed_bit_torque_std_nm",
    "now_speed_rad_s": "now_bit_speed_rad_s",
    "now_speed_std_rad_s": "now_bit_speed_std_rad_s",
    "now_torque_nm": "now_bit_torque_nm",
    "now_torque_std_nm": "now_bit_torque_std_nm",
    "forecast_time_s": "forecast_time_ns",
    "forecast_speed_rad_s": "forecast_bit_speed_rad_s",
    "forecast_speed_std_rad_s": "forecast_bit_speed_std_rad_s",
    "forecast_torque_nm": "forecast_bit_torque_nm",
    "forecast_torque_std_nm": "forecast_bit_torque_std_nm",
    "quality": "quality",
}
"""The columns of an estimates table, in order, and the field of an Estimate that each shows."""

_FAR_S = 9e9
"""Nanoseconds since 1970 fit 64 bits until 2262; milliseconds taken for seconds do not."""


@dataclass(frozen=True, slots=True)
class SurfaceTable:
    """What a rig measured, SI; float64[n] each, the time strictly increasing, all finite."""

    time_s: Floats
    motor_torque_nm: Floats
    motor_speed_rad_s: Floats

    @property
    def time_ns(self) -> npt.NDArray[np.int64]:
        """The time in integer nanoseconds, rounded.

        Whole seconds apart from the rest: a double that counts Unix nanoseconds knows them to 256.
        """
        whole = np.floor(self.time_s)
        return whole.astype(np.int64) * 1_000_000_000 + np.rint((self.time_s - whole) * 1e9).astype(np.int64)


def read_surface(
    path: Path, columns: Mapping[str, str] | None = None, units: Mapping[str, str] | None = None
) -> SurfaceTable:
    """Read a surface table from .csv or .parquet.

    `columns` and `units` give, by our name for a column, the file's name for it and the unit it is
    in. Raises InputError naming the line (CSV, the header being line 1) or row (Parquet) at fault,
    ConfigError for a unit that does not measure what the column holds, or another kind of file.
    """
    names = {column: (columns or {}).get(column, column) for column in SURFACE_UNITS}
    factors = {column: _factor(path, column, (units or {}).get(column)) for column in SURFACE_UNITS}
    source = _source(path)
    parts: dict[str, list[Floats]] = {column: [] for column in SURFACE_UNITS}
    row = 0
    for batch in source.batches(tuple(names.values())):
        for column, name in names.items():
            parts[column].append(_numbers(source, row, name, batch.column(name)))
        row += batch.num_rows
    if row == 0:
        raise InputError(f"{path}: has a header but no rows")
    table = SurfaceTable(**{column: np.concatenate(parts[column]) * factors[column] for column in parts})
    _check_times(source, names["time_s"], table.time_s)
    return table


def surface_samples(table: SurfaceTable) -> Iterator[tuple[str, Sample]]:
    """Yield a table's rows as a rig would send them: torque, then speed, numbered from 0."""
    rows = zip(
        table.time_ns.tolist(), table.motor_torque_nm.tolist(), table.motor_speed_rad_s.tolist(), strict=True
    )
    for number, (time_ns, *values) in enumerate(rows):
        for topic, value in zip((SURFACE_TORQUE, SURFACE_SPEED), values, strict=True):
            yield topic, Sample(time_ns=time_ns, value=value, sequence=number)


def write_surface(path: Path, table: SurfaceTable) -> None:
    """Write a surface table to .csv or .parquet; NaN, where a channel has no sample, as nothing."""
    _write(path, {column: pa.array(getattr(table, column), from_pandas=True) for column in SURFACE_UNITS})


def write_estimates(path: Path, columns: Mapping[str, npt.NDArray[Any]]) -> None:
    """Write an estimates table to .csv or .parquet, one row a tick.

    `columns` holds every one of ESTIMATE_FIELDS: float64[n], NaN for not known, which is written as
    nothing (CSV) or null; `quality` in words (good, uncertain, bad). Numbers read back bit for bit.
    """
    _write(path, {name: pa.array(columns[name], from_pandas=True) for name in ESTIMATE_FIELDS})


def is_csv(path: Path) -> bool:
    """Whether a table's file is CSV, and not Parquet; ConfigError for another name."""
    if path.suffix not in (".csv", ".parquet"):
        raise ConfigError(f"{path}: a table's name must end in .csv or .parquet")
    return path.suffix == ".csv"


class _Source(Protocol):
    path: Path

    def batches(self, names: tuple[str, ...]) -> Iterator[pa.RecordBatch]:
        """Yield these columns, a batch of rows at a time."""

    def place(self, row: int) -> str:
        """Where a row (from 0) stands, as its reader would look for it."""


class _Csv:
    def __init__(self, path: Path) -> None:
        self.path = path

    def batches(self, names: tuple[str, ...]) -> Iterator[pa.RecordBatch]:
        _check_columns(self.path, names, self._header())
        ragged: list[Any] = []

        def refuse(row: Any) -> str:
            ragged.append(row)
            return "error"

        # As text, to be read as numbers here: Arrow's own message would not name the line.
        options = arrow_csv.ConvertOptions(
            include_columns=names,
            column_types=dict.fromkeys(names, pa.string()),
            null_values=[""],
            strings_can_be_null=True,
        )
        try:
            yield from arrow_csv.open_csv(
                self.path,
                read_options=arrow_csv.ReadOptions(use_threads=False),  # else rows are not counted
                parse_options=arrow_csv.ParseOptions(invalid_row_handler=refuse),
                convert_options=options,
            )
        except pa.ArrowInvalid as error:
            if not ragged or ragged[-1].number is None:
                raise InputError(f"{self.path}: is no CSV table: {error}") from error
            bad = ragged[-1]
            raise InputError(
                f"{self.path}, {self.place(bad.number - 2)}: has {bad.actual_columns} values, "
                f"where the header names {bad.expected_columns}"
            ) from error

    def _header(self) -> list[str]:
        try:
            with self.path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
                return next(filter(None, csv.reader(file)))
        except StopIteration as error:
            raise InputError(f"{self.path}: is empty: a header and rows were expected") from error
        except csv.Error as error:
            raise InputError(f"{self.path}: is no CSV table: {error}") from error

    def place(self, row: int) -> str:
        with self.path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
            reader = csv.reader(file)
            for _ in islice(filter(None, reader), row + 2):  # with the header, without blank lines
                pass
            return f"line {reader.line_num}"


class _Parquet:
    def __init__(self, path: Path) -> None:
        self.path = path

    def batches(self, names: tuple[str, ...]) -> Iterator[pa.RecordBatch]:
        try:
            with arrow_parquet.ParquetFile(self.path) as file:
                _check_columns(self.path, names, file.schema_arrow.names)
                yield from file.iter_batches(columns=list(names))
        except pa.ArrowException as error:
            raise InputError(f"{self.path}: is no Parquet table: {error}") from error

    def place(self, row: int) -> str:
        return f"row {row + 1}"


def _source(path: Path) -> _Source:
    kind = _Csv if is_csv(path) else _Parquet
    try:
        path.open("rb").close()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    return kind(path)


def _factor(path: Path, column: str, unit: str | None) -> float:
    si = SURFACE_UNITS[column]
    try:
        return factor(unit or si, si)
    except ValueError as error:
        raise ConfigError(f"{path}: {unit!r} is no unit for {column}: write for example {si!r}") from error


def _check_columns(path: Path, names: tuple[str, ...], present: list[str]) -> None:
    for name in names:
        if present.count(name) != 1:
            fault = "no column" if name not in present else "more than one column"
            there = ", ".join(map(repr, present))
            raise InputError(f"{path}: has {fault} {name!r}; its columns are: {there:.300}")


def _numbers(source: _Source, first_row: int, name: str, values: pa.Array) -> Floats:
    """A column's values as finite numbers; InputError names the row of the first that is none."""

    def fault(row: int, what: str) -> InputError:
        return InputError(
            f"{source.path}, {source.place(first_row + row)}: {name} {what}: a finite number was expected"
        )

    if values.null_count:
        raise fault(pc.index(values.is_null(), True).as_py(), "is empty")
    if pa.types.is_string(values.type):
        values = pc.utf8_trim_whitespace(values)
    elif not (pa.types.is_integer(values.type) or pa.types.is_floating(values.type)):
        raise fault(0, f"is of type {values.type}")
    try:
        numbers: Floats = values.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
    except pa.ArrowInvalid as error:
        row, text = next((i, v) for i, v in enumerate(values.to_pylist()) if not _is_number(v))
        raise fault(row, f"is {text!r}") from error
    if not np.isfinite(numbers).all():
        row = int(np.argmin(np.isfinite(numbers)))
        raise fault(row, f"is {numbers[row]}")
    return numbers


def _is_number(text: str) -> bool:
    try:
        pa.scalar(text).cast(pa.float64())
    except pa.ArrowInvalid:
        return False
    return True


def _check_times(source: _Source, name: str, time_s: Floats) -> None:
    far = np.abs(time_s) > _FAR_S
    if far.any():
        row = int(np.argmax(far))
        raise InputError(
            f"{source.path}, {source.place(row)}: {name} is {time_s[row]:g} s, which no clock shows: "
            "is it in another unit?"
        )
    back = np.diff(time_s) <= 0
    if back.any():
        row = int(np.argmax(back)) + 1
        raise InputError(
            f"{source.path}, {source.place(row)}: {name} is {time_s[row]:.12g} s after "
            f"{time_s[row - 1]:.12g} s: time must increase from row to row"
        )


def _write(path: Path, columns: dict[str, pa.Array]) -> None:
    """Write beside the name and rename, so that no half table bears it."""
    table = pa.table(columns)
    part = path.with_name(f"{path.name}.part")
    as_csv = is_csv(path)
    try:
        with part.open("wb") as file:
            if as_csv:
                file.write((",".join(columns) + "\n").encode())  # Arrow would put the names in quotes
                options = arrow_csv.WriteOptions(include_header=False, quoting_style="none")
                arrow_csv.write_csv(table, file, options)
            else:
                arrow_parquet.write_table(table, file)
        part.rename(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from error
