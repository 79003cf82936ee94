"""Tables written a piece at a time: however long one is, a hundred thousand rows of it are in memory."""

import contextlib
import errno
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from vsensor.errors import ConfigError, InputError
from vsensor.tables.layout import DEPTH_COLUMNS
from vsensor.tables.sinks import SINKS, Sink
from vsensor.tables.surface import SurfaceTable

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

SURFACE_COLUMNS = ("time_s", "motor_torque_nm", "motor_speed_rad_s", "time_ns")
"""The columns of a surface table, in order; those of depths come behind them, where there are any."""

_ROWS = 100_000
"""Rows put at once: enough that a group of them is worth its head in a Parquet file."""

Columns = Mapping[str, npt.NDArray[Any]]


def check_writable(path: Path) -> None:
    """Raise ConfigError for a name that ends in what we do not write, InputError where no file can stand."""
    if path.suffix not in SINKS:
        raise ConfigError(f"{path}: a table's name must end in {' or '.join(SINKS)}")
    if path.is_dir() or not path.parent.is_dir():
        why = os.strerror(errno.EISDIR if path.is_dir() else errno.ENOENT)
        raise InputError(f"{path}: cannot be written: {why}")


class TableWriter:
    """Writes .csv, .parquet or .npz beside its name, and renames it when complete: no half table bears it.

    NaN and None, for what is not known, become nothing (CSV), null (Parquet), or NaN and no text (NumPy).
    Numbers read back bit for bit. Raises ConfigError for another kind of file, InputError where it cannot
    be written.
    """

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        check_writable(path)
        self.path = path
        self.rows = 0
        """Rows so far."""
        self._names = tuple(columns)
        self._part = path.with_name(f"{path.name}.part")
        self._waiting: list[Columns] = []
        self._held = 0
        self._sink: Sink | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            with self._telling():
                self._put()
                self._opened().close()
                self._part.rename(self.path)
        elif self._sink is not None:
            with contextlib.suppress(OSError):
                self._sink.abandon()
            self._part.unlink(missing_ok=True)

    def write(self, columns: Columns) -> None:
        """Add n rows, an array of n for each column."""
        count = len(columns[self._names[0]])
        self.rows += count
        self._held += count
        self._waiting.append(columns)
        if self._held >= _ROWS:
            with self._telling():
                self._put()

    def _put(self) -> None:
        if self._waiting:
            pieces, self._waiting, self._held = self._waiting, [], 0
            self._opened().put(
                {name: np.concatenate([piece[name] for piece in pieces]) for name in self._names}
            )

    def _opened(self) -> Sink:
        if self._sink is None:
            self._sink = SINKS[self.path.suffix](self._part, self._names)
        return self._sink

    @contextlib.contextmanager
    def _telling(self) -> Any:
        try:
            yield
        except OSError as error:
            self._part.unlink(missing_ok=True)
            raise InputError(f"{self.path}: cannot be written: {error.strerror or error}") from error


def surface_columns(table: SurfaceTable) -> Columns:
    """What a surface table holds, as it is written."""
    depths = {DEPTH_COLUMNS[topic]: depth for topic, depth in table.depths_m.items()}
    return {**{column: getattr(table, column) for column in SURFACE_COLUMNS}, **depths}


def write_surface(path: Path, table: SurfaceTable) -> None:
    """Write a surface table; NaN, where a channel has no sample, as what is not known."""
    columns = surface_columns(table)
    with TableWriter(path, tuple(columns)) as writer:
        writer.write(columns)


def write_estimates(path: Path, columns: Columns) -> None:
    """Write an estimates table, one row a tick.

    `columns` holds every one of ESTIMATE_FIELDS: float64[n], NaN for not known; `quality` in words (good,
    uncertain, bad), None for not known.
    """
    with TableWriter(path, tuple(ESTIMATE_FIELDS)) as writer:
        writer.write(columns)
