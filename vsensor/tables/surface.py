"""What a rig measured, from a table: its columns found, in SI, each time later than the one before."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import count
from pathlib import Path
from typing import Self

import numpy as np
import pyarrow as pa

from vsensor.errors import ConfigError, InputError
from vsensor.grid import NS, seconds
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.tables.cells import BadCellError, Floats, measured, numbers
from vsensor.tables.sources import Source, source_of
from vsensor.tables.times import IN_SECONDS, TimeForm, Times
from vsensor.units import factor


@dataclass(frozen=True)
class Layout:
    """What a file calls the columns of a surface table, and how each is told; `date` is a column or none."""

    time: str = "time_s"
    torque: str = "motor_torque_nm"
    speed: str = "motor_speed_rad_s"
    date: str = ""
    form: TimeForm = IN_SECONDS
    torque_unit: str = "N*m"
    speed_unit: str = "rad/s"

    @property
    def names(self) -> tuple[str, ...]:
        """The columns that are read."""
        return (self.time, self.torque, self.speed, *([self.date] if self.date else []))


PLAIN = Layout()


@dataclass(frozen=True, slots=True)
class SurfaceTable:
    """What a rig measured, SI; n rows, time strictly increasing, NaN where a channel has no sample."""

    time_ns: Times
    motor_torque_nm: Floats
    motor_speed_rad_s: Floats

    @classmethod
    def at_seconds(cls, time_s: Floats, torque: Floats, speed: Floats) -> Self:
        """With times in seconds, to the nearest nanosecond."""
        whole = np.floor(time_s)
        time_ns = whole.astype(np.int64) * NS + np.rint((time_s - whole) * 1e9).astype(np.int64)
        return cls(time_ns, torque, speed)

    @property
    def time_s(self) -> Floats:
        """The time in seconds, as the nearest doubles."""
        return seconds(self.time_ns)

    @property
    def samples(self) -> tuple[int, int]:
        """How many there are of torque, and of speed."""
        torque, speed = (int(np.isfinite(v).sum()) for v in (self.motor_torque_nm, self.motor_speed_rad_s))
        return torque, speed

    def __len__(self) -> int:
        return len(self.time_ns)


def read_surface(path: Path, layout: Layout = PLAIN) -> SurfaceTable:
    """Read a surface table whole, as `surface_pieces` does it piece by piece."""
    pieces = list(surface_pieces(path, layout))
    columns = ([getattr(piece, field.name) for piece in pieces] for field in fields(SurfaceTable))
    return SurfaceTable(*map(np.concatenate, columns))


def surface_pieces(path: Path, layout: Layout = PLAIN, *, whole: bool = False) -> Iterator[SurfaceTable]:
    """Read a surface table from .csv, .parquet, .feather or .arrow, some thousands of rows at a time.

    An empty cell, or NaN, is a channel without a sample at that time; where rows must be `whole`, a fault.
    Raises InputError naming the line (CSV, the header being line 1) or row (others) at fault, ConfigError
    for a unit that does not measure what the column holds, or another kind of file.
    """
    scales = (
        _scale(path, "motor_torque_nm", layout.torque_unit, "N*m"),
        _scale(path, "motor_speed_rad_s", layout.speed_unit, "rad/s"),
    )
    source = source_of(path)
    row, last_ns = 0, None
    for batch in source.batches(layout.names):
        if not batch.num_rows:
            continue
        reader = _Batch(source, row, batch)
        time_ns = reader.times(layout)
        reader.check_times(layout.time, time_ns, last_ns)
        values = (reader.values(name, whole) for name in (layout.torque, layout.speed))
        yield SurfaceTable(time_ns, *(value * scale for value, scale in zip(values, scales, strict=True)))
        row, last_ns = row + batch.num_rows, int(time_ns[-1])
    if row == 0:
        raise InputError(f"{path}: has a header but no rows")


def surface_samples(table: SurfaceTable, first: tuple[int, int] = (0, 0)) -> Iterator[tuple[str, Sample]]:
    """Yield a table's rows as a rig would send them: torque, then speed, each numbered from its `first`."""
    rows = zip(
        table.time_ns.tolist(), table.motor_torque_nm.tolist(), table.motor_speed_rad_s.tolist(), strict=True
    )
    numbers = tuple(map(count, first))
    for time_ns, *values in rows:
        for topic, value, number in zip((SURFACE_TORQUE, SURFACE_SPEED), values, numbers, strict=True):
            if math.isfinite(value):
                yield topic, Sample(time_ns=time_ns, value=value, sequence=next(number))


@dataclass(frozen=True)
class _Batch:
    """Some rows of a file, the first of which is its row `first`."""

    source: Source
    first: int
    rows: pa.RecordBatch

    def values(self, name: str, whole: bool) -> Floats:
        try:
            return (numbers if whole else measured)(self.rows.column(name))
        except BadCellError as bad:
            raise self._fault(bad.row, name, str(bad)) from bad

    def times(self, layout: Layout) -> Times:
        dates = self.rows.column(layout.date) if layout.date else None
        try:
            return layout.form.read(self.rows.column(layout.time), dates)
        except BadCellError as bad:
            raise self._fault(bad.row, layout.time, str(bad)) from bad
        except ConfigError as error:
            raise ConfigError(f"{self.source.path}: {layout.time}: {error}") from error

    def check_times(self, name: str, time_ns: Times, last_ns: int | None) -> None:
        """Each must be later than the one before, the first than `last_ns`."""
        known = time_ns if last_ns is None else np.append(last_ns, time_ns)
        back = np.diff(known) <= 0
        if back.any():
            at = int(np.argmax(back))
            row = at + len(time_ns) - len(known) + 1
            before, after = (seconds(known[at : at + 2])).tolist()
            fault = f"is {after:.12g} s after {before:.12g} s: time must increase from row to row"
            raise self._fault(row, name, fault)

    def _fault(self, row: int, name: str, fault: str) -> InputError:
        return InputError(f"{self.source.path}, {self.source.place(self.first + row)}: {name} {fault}")


def _scale(path: Path, column: str, unit: str, si: str) -> float:
    try:
        return factor(unit, si)
    except ValueError as error:
        raise ConfigError(f"{path}: {unit!r} is no unit for {column}: write for example {si!r}") from error
