"""What a rig measured, from a table: its columns found, in SI; what is wrong is told by its place."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import Self

import numpy as np
import pyarrow as pa

from vsensor.errors import ConfigError, InputError
from vsensor.grid import NS, seconds
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.tables.cells import BadCellError, Floats, as_told, blanked, is_text, measured, numbers
from vsensor.tables.course import Course, Times
from vsensor.tables.findings import Findings
from vsensor.tables.layout import PLAIN, Layout
from vsensor.tables.source import Source
from vsensor.tables.sources import source_of


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
    path: Path,
    layout: Layout = PLAIN,
    *,
    whole: bool = False,
    as_it_came: bool = False,
    findings: Findings | None = None,
) -> Iterator[SurfaceTable]:
    """Read a surface table, thousands of rows at a time: .csv, .parquet, .feather, .arrow, .arrows, .npz.

    An empty cell, or NaN, is a channel without a sample at that time; where rows must be `whole`, one
    of torque or speed is a fault. Rows out of order, times before 0 and infinite values are faults, too, but
    not where all is taken `as_it_came`, without depths: for the intake, which refuses samples one by one, and
    counts them. `findings` are told of what is read.
    Raises InputError naming the line (CSV, the header being line 1) or row (others) at fault, ConfigError
    for a unit that does not measure what the column holds, or another kind of file.
    """
    source = source_of(path, layout.head)
    layout = layout.among(source.columns(), depths=not as_it_came)
    try:
        layout = layout.told_by(source.units())
        *scales, depth_scale = layout.scales()
        columns = layout.columns
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error
    findings = findings or Findings()
    read = numbers if whole else as_told if as_it_came else measured
    row, course, order = 0, Course(), _Order()
    for batch in source.batches(columns):
        if not batch.num_rows:
            continue
        reader = _Batch(source, row, batch, layout, findings)
        time_ns = reader.times(course)
        if not as_it_came:
            order.check(reader, time_ns)
        values = (reader.values(name, read) for name in (layout.torque, layout.speed))
        depths = {topic: reader.values(name, measured) * depth_scale for topic, name in layout.depths.items()}
        torque, speed = (value * scale for value, scale in zip(values, scales, strict=True))
        yield SurfaceTable(time_ns, torque, speed, depths)
        row += batch.num_rows
    if row == 0:
        raise InputError(f"{path}: has a header but no rows")
    if {layout.torque, layout.speed} <= set(findings.empty()):
        raise InputError(f"{path}: neither {layout.torque} nor {layout.speed} has any value")


class SurfaceSamples:
    """The rows of a table, piece by piece, as a rig would send them; each channel numbered from 0."""

    def __init__(self) -> None:
        self._numbers: Counter[str] = Counter()
        self._told: dict[str, tuple[int, bool]] = {}
        """The whole second of the last row, and whether it told each depth."""

    def of(self, table: SurfaceTable) -> Iterator[tuple[str, Sample]]:
        """Yield those of a piece: depths, torque, speed of each row; what repeats a depth once a second."""
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
        """What is told of a depth: of what a table repeats from row to row the first of each second."""
        known = np.isfinite(depth_m)
        last_s, last_known = self._told.get(topic, (-1, False))
        second = time_ns // NS
        repeated = known & np.append(last_known, known[:-1])
        repeated &= second == np.append(last_s, second[:-1])
        self._told[topic] = int(second[-1]), bool(known[-1])
        return np.where(repeated, np.nan, depth_m)


@dataclass(frozen=True)
class _Batch:
    """Some rows of a file, the first of which is its row `first`."""

    source: Source
    first: int
    rows: pa.RecordBatch
    layout: Layout
    findings: Findings

    def values(self, name: str, read: Callable[[pa.Array], Floats]) -> Floats:
        try:
            found = read(blanked(self.rows.column(name), self.layout.nulls))
        except BadCellError as bad:
            raise self.fault(bad.row, f"{name} {bad}") from bad
        self.findings.look(name, found)
        return found

    def times(self, course: Course) -> Times:
        time, date = self.layout.time, self.layout.date
        dates = self.rows.column(date) if date else None
        try:
            return self.layout.form.read(self.rows.column(time), dates, course)
        except BadCellError as bad:
            raise self.fault(bad.row, f"{time} {bad}") from bad
        except ConfigError as error:
            raise ConfigError(f"{self.source.path}: {time}: {error}") from error

    def shown(self, row: int, time_ns: int) -> str:
        """A time as it stands in the table."""
        cells = [self.rows.column(name)[row] for name in (self.layout.date, self.layout.time) if name]
        kind = cells[-1].type
        if pa.types.is_duration(kind):
            return f"{Decimal(time_ns).scaleb(-9).normalize():f} s"
        if pa.types.is_temporal(kind):
            return str(np.datetime64(time_ns, "ns"))
        told = " ".join(str(cell).strip() for cell in cells)
        return told if is_text(told) else f"{told.removesuffix('.0')} {self.layout.form.unit or 's'}"

    def fault(self, row: int, fault: str) -> InputError:
        hint = ": is it a line of units? vsensor import --units-line" if self._tells_units(row) else ""
        return InputError(f"{self.source.path}, {self.source.place(self.first + row)}: {fault}{hint}")

    def _tells_units(self, row: int) -> bool:
        """Whether a row is the first, and holds no number but words."""
        if self.first + row or self.source.path.suffix.lower() != ".csv" or self.layout.head.units:
            return False
        cells = [self.rows.column(name)[0].as_py() or "" for name in self.layout.columns]
        return any(cells) and not any(map(str.isdigit, "".join(cells)))


class _Order:
    """Times that increase from row to row, from 0 on, where a session's clock begins."""

    def __init__(self) -> None:
        self._last_ns, self._last = -1, ""

    def check(self, batch: _Batch, time_ns: Times) -> None:
        """Raise InputError for the first row that does not come after the one before it."""
        known = np.append(self._last_ns, time_ns)
        row = int(np.argmax(np.diff(known) <= 0))
        if time_ns[row] <= known[row]:
            name = batch.layout.time
            shown = batch.shown(row, int(time_ns[row]))
            if time_ns[row] < 0:
                raise batch.fault(row, f"{name} is {shown}: a session's times begin with 0, which is 1970")
            before = batch.shown(row - 1, int(known[row])) if row else self._last
            raise batch.fault(row, f"{name} is {shown} after {before}: time must increase from row to row")
        self._last_ns = int(time_ns[-1])
        self._last = batch.shown(len(time_ns) - 1, self._last_ns)
