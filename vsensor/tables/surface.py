"""What a rig measured, from a table: its columns found, in SI; what is wrong is told by its place."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import numpy as np
import pyarrow as pa

from vsensor.errors import ConfigError, InputError
from vsensor.grid import NS, seconds
from vsensor.messages import (
    SURFACE_BIT_DEPTH,
    SURFACE_HOLE_DEPTH,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Sample,
)
from vsensor.tables.cells import BadCellError, Floats, as_told, measured, numbers
from vsensor.tables.sources import Source, source_of
from vsensor.tables.times import IN_SECONDS, TimeForm, Times
from vsensor.units import factor


@dataclass(frozen=True)
class Layout:
    """What a file calls the columns of a surface table, and how each is told; date and depths may be none."""

    time: str = "time_s"
    torque: str = "motor_torque_nm"
    speed: str = "motor_speed_rad_s"
    date: str = ""
    form: TimeForm = IN_SECONDS
    torque_unit: str = "N*m"
    speed_unit: str = "rad/s"
    bit_depth: str = ""
    hole_depth: str = ""
    depth_unit: str = "m"

    @property
    def depths(self) -> Mapping[str, str]:
        """The columns of depths that there are, by topic."""
        depths = {SURFACE_BIT_DEPTH: self.bit_depth, SURFACE_HOLE_DEPTH: self.hole_depth}
        return {topic: column for topic, column in depths.items() if column}

    @property
    def names(self) -> tuple[str, ...]:
        """The columns that are read."""
        return (
            self.time,
            self.torque,
            self.speed,
            *([self.date] if self.date else []),
            *self.depths.values(),
        )


PLAIN = Layout()


@dataclass(frozen=True, slots=True)
class SurfaceTable:
    """What a rig measured, SI; n rows, NaN where a channel has no sample.

    Time increases from row to row, and all else is finite, but where rows were taken as they came.
    """

    time_ns: Times
    motor_torque_nm: Floats
    motor_speed_rad_s: Floats
    depths_m: Mapping[str, Floats] = field(default_factory=dict)
    """Of bit and hole, where they are told, by topic."""

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
        torque, speed = (int((~np.isnan(v)).sum()) for v in (self.motor_torque_nm, self.motor_speed_rad_s))
        return torque, speed

    def __len__(self) -> int:
        return len(self.time_ns)


def read_surface(path: Path, layout: Layout = PLAIN) -> SurfaceTable:
    """Read torque and speed of a surface table whole, as `surface_pieces` does it piece by piece."""
    pieces = list(surface_pieces(path, layout))
    return SurfaceTable(
        np.concatenate([piece.time_ns for piece in pieces]),
        np.concatenate([piece.motor_torque_nm for piece in pieces]),
        np.concatenate([piece.motor_speed_rad_s for piece in pieces]),
    )


def surface_pieces(
    path: Path, layout: Layout = PLAIN, *, whole: bool = False, as_it_came: bool = False
) -> Iterator[SurfaceTable]:
    """Read a surface table from .csv, .parquet, .feather, .arrow or .arrows, thousands of rows at a time.

    An empty cell, or NaN, is a channel without a sample at that time; where rows must be `whole`, one
    of torque or speed is a fault. Rows out of order and infinite values are faults, too, but not where all is
    taken `as_it_came`: for the intake, which refuses samples one by one, and counts them.
    Raises InputError naming the line (CSV, the header being line 1) or row (others) at fault, ConfigError
    for a unit that does not measure what the column holds, or another kind of file.
    """
    scales = (
        _scale(path, "motor_torque_nm", layout.torque_unit, "N*m"),
        _scale(path, "motor_speed_rad_s", layout.speed_unit, "rad/s"),
    )
    depth_scale = _scale(path, "a depth", layout.depth_unit, "m")
    source = source_of(path)
    row, last_ns = 0, None
    for batch in source.batches(layout.names):
        if not batch.num_rows:
            continue
        reader = _Batch(source, row, batch)
        time_ns = reader.times(layout)
        if not as_it_came:
            reader.check_times(layout.time, time_ns, last_ns)
        read = numbers if whole else as_told if as_it_came else measured
        values = (reader.values(name, read) for name in (layout.torque, layout.speed))
        depths = {topic: reader.values(name, measured) * depth_scale for topic, name in layout.depths.items()}
        torque, speed = (value * scale for value, scale in zip(values, scales, strict=True))
        yield SurfaceTable(time_ns, torque, speed, depths)
        row, last_ns = row + batch.num_rows, int(time_ns[-1])
    if row == 0:
        raise InputError(f"{path}: has a header but no rows")


class SurfaceSamples:
    """The rows of a table, piece by piece, as a rig would send them; each channel numbered from 0."""

    def __init__(self) -> None:
        self._numbers: Counter[str] = Counter()
        self._told_s: dict[str, int] = {}
        """The whole second in which each depth was told last."""

    def of(self, table: SurfaceTable) -> Iterator[tuple[str, Sample]]:
        """Yield those of a piece: depths, torque and speed of each row; a depth once a second at most."""
        depths = {topic: self._seldom(topic, table.time_ns, m) for topic, m in table.depths_m.items()}
        columns = {
            **depths,
            SURFACE_TORQUE: table.motor_torque_nm,
            SURFACE_SPEED: table.motor_speed_rad_s,
        }
        rows = zip(table.time_ns.tolist(), *(column.tolist() for column in columns.values()), strict=True)
        for time_ns, *values in rows:
            for topic, value in zip(columns, values, strict=True):
                if math.isfinite(value):
                    yield topic, Sample(time_ns=time_ns, value=value, sequence=self._numbers[topic])
                    self._numbers[topic] += 1

    def _seldom(self, topic: str, time_ns: Times, depth_m: Floats) -> Floats:
        """What is told of a depth, the first of each second: tables repeat it from row to row."""
        known = np.flatnonzero(np.isfinite(depth_m))
        second = time_ns[known] // NS
        first = known[np.diff(second, prepend=self._told_s.get(topic, -1)) != 0]
        if len(known):
            self._told_s[topic] = int(second[-1])
        seldom = np.full_like(depth_m, np.nan)
        seldom[first] = depth_m[first]
        return seldom


@dataclass(frozen=True)
class _Batch:
    """Some rows of a file, the first of which is its row `first`."""

    source: Source
    first: int
    rows: pa.RecordBatch

    def values(self, name: str, read: Callable[[pa.Array], Floats]) -> Floats:
        try:
            return read(self.rows.column(name))
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
