"""Times as tables have them, in nanoseconds: numbers in any unit, ISO 8601, date and time apart."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from typing import Self
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from vsensor.errors import ConfigError
from vsensor.grid import NS
from vsensor.tables.cells import BadCellError, Floats, as_floats, filled, numbers
from vsensor.tables.course import Course, Times
from vsensor.units import factor

_FAR_S = 9e9
"""Nanoseconds since 1970 fit 64 bits until 2262; milliseconds taken for seconds do not."""
_EXACT = {"s": NS, "ms": 1_000_000, "us": 1000, "µs": 1000, "ns": 1}
"""Units of which whole numbers are so many whole nanoseconds."""
_DATE = r"^(\d{4})[-/.]?(\d{2})[-/.]?(\d{2})", r"\1-\2-\3"
"""2026-11-24, 2026/11/24, 2026.11.24 and 20261124 are one date."""
_SELDOM = (
    (r"^(\S{10}[T ]\d{2})(\d{2})(\d{2})", r"\1:\2:\3"),
    (r"(:\d{2}),(\d)", r"\1.\2"),
    (r"\s*(?:UTC|GMT)$", "Z"),
    (r"\s+([+-]\d{2}:?\d{2})$", r"\1"),
)
"""Without colons, with a comma before the fraction, UTC in letters, a space before the offset."""
_OF_DAY = re.compile(r"\d{2}:\d{2}(:\d{2}([.,]\d+)?)?")
_STAMP = pa.timestamp("ns")
_SPAN = pa.duration("ns")
_YEAR = re.compile(r"%[YyGcx]")
"""What a pattern tells a year by: without, strptime takes 1900, and a session's clock begins with 1970."""
_DAY = re.compile(r"%[YyGcxdjmbBUWVaAuw]")
"""And a day."""


@dataclass(frozen=True)
class TimeForm:
    """How a table tells the time.

    `unit` is that of a column of numbers, seconds where none is told; `pattern` that of text which is not
    ISO 8601, as strptime has it; `zone` where the clock hangs that tells no offset of its own.
    """

    unit: str = ""
    pattern: str = ""
    zone: str = "UTC"

    def checked(self) -> Self:
        """The same; ConfigError for a unit or a zone that is none, whether or not a table asks for it."""
        _ = self._nanoseconds
        if self.zone != "UTC":  # times in numbers need no list of zones, which a machine may lack
            _ = self._hangs
        return self

    def told_by(self, unit: str) -> Self:
        """The same in a unit that a file tells, where no other is told and this is one: not for hh:mm:ss."""
        told = replace(self, unit=self.unit or unit)
        try:
            return told.checked()
        except ConfigError:
            return self

    def read(self, values: pa.Array, dates: pa.Array | None = None, course: Course | None = None) -> Times:
        """A column of times, or of times of day with its dates, in nanoseconds; shape (n,).

        `course` is that of the rows before. Raises BadCellError for the first that is none, ConfigError for a
        unit or a zone that is none.
        """
        course = course or Course()
        values = filled(values)
        if dates is not None:
            values = _joined(filled(dates), values)
        kind = values.type
        if pa.types.is_duration(kind):
            return _integers(_cast(values, _SPAN))
        if pa.types.is_time(kind):
            return course.on_days(_integers(values.cast(pa.time64("ns"))))
        if pa.types.is_timestamp(kind) or pa.types.is_date(kind):
            zone = kind.tz if pa.types.is_timestamp(kind) else None
            return self._stamps(_cast(values, pa.timestamp("ns", zone)), course)
        if pa.types.is_string(kind) and (self.pattern or as_floats(values[:1]) is None):
            return self._by_pattern(values, course) if self.pattern else self._iso(values, course)
        return self._counted(values)

    @cached_property
    def _nanoseconds(self) -> float:
        try:
            return factor(self.unit or "s", "s") * NS
        except ValueError as error:
            raise ConfigError(f"{self.unit!r} is no unit of time: write for example 'ms'") from error

    @cached_property
    def _hangs(self) -> ZoneInfo:
        try:
            return ZoneInfo(self.zone)
        except (ZoneInfoNotFoundError, ValueError, OSError) as error:  # such as a folder of zones
            raise ConfigError(f"{self.zone!r} is no time zone: write for example 'Europe/Oslo'") from error

    def _counted(self, values: pa.Array) -> Times:
        """Numbers in a unit: whole ones exactly, others to the nearest nanosecond."""
        exact, whole = _EXACT.get(self.unit or "s"), _whole(values)
        if exact and whole is not None:
            _check_near(whole / (NS / exact))
            return whole * exact
        found = numbers(values) * (self._nanoseconds / NS)
        _check_near(found)
        seconds = np.floor(found)
        # Apart from the rest: a double that counts nanoseconds since 1970 knows them to 256.
        return seconds.astype(np.int64) * NS + np.rint((found - seconds) * 1e9).astype(np.int64)

    def _iso(self, text: pa.Array, course: Course) -> Times:
        of_day = _OF_DAY.fullmatch(text[0].as_py()) is not None
        plain = pc.binary_join_element_wise("1970-01-01", text, " ") if of_day else text
        plain = pc.replace_substring_regex(plain, *_DATE)
        for forms in ((), _SELDOM):  # the usual ones at once
            for form in forms:
                plain = pc.replace_substring_regex(plain, *form)
            for kind in (_STAMP, pa.timestamp("ns", "UTC")):
                try:
                    stamps = plain.cast(kind)
                except pa.ArrowInvalid:
                    continue
                return course.on_days(_integers(stamps)) if of_day else self._stamps(stamps, course)
        row = _first_bad(plain, lambda told: pa.array([told]).cast(_kind_of(told)))
        raise BadCellError(
            row,
            f"is {text[row].as_py()!r}: a time such as 2026-11-24T08:15:30.25 was expected: vsensor import "
            f'--time-format "%d.%m.%Y %H:%M:%S" tells another form, --date-column where dates stand apart',
        )

    def _by_pattern(self, text: pa.Array, course: Course) -> Times:
        found = np.empty(len(text), np.int64)
        without_year, without_day = not _YEAR.search(self.pattern), not _DAY.search(self.pattern)
        hangs = False
        for row, told in enumerate(text.to_pylist()):
            try:
                time = datetime.strptime(told, self.pattern)
            except ValueError as error:
                raise BadCellError(
                    row, f"is {told!r}: a time of the form {self.pattern!r} was expected (--time-format)"
                ) from error
            if without_year:
                time = time.replace(year=1970)
            hangs = time.tzinfo is None
            since = (time.replace(tzinfo=UTC) if hangs else time) - datetime(1970, 1, 1, tzinfo=UTC)
            found[row] = (since.days * 86_400 + since.seconds) * NS + since.microseconds * 1000
        if without_day:
            return course.on_days(found)
        return self._hung(found, course) if hangs else found

    def _stamps(self, stamps: pa.Array, course: Course) -> Times:
        return self._hung(_integers(stamps), course) if stamps.type.tz is None else _integers(stamps)

    def _hung(self, wall: Times, course: Course) -> Times:
        """Times that a clock showed where it hangs."""
        if self.zone == "UTC":
            return wall
        shown, key = pa.array(wall).cast(_STAMP), self._hangs.key
        return course.told_apart(
            wall,
            _integers(pc.assume_timezone(shown, key, ambiguous="earliest", nonexistent="latest")),
            _integers(pc.assume_timezone(shown, key, ambiguous="latest", nonexistent="latest")),
        )


IN_SECONDS = TimeForm()


def _joined(dates: pa.Array, times: pa.Array) -> pa.Array:
    if pa.types.is_time(times.type) and (pa.types.is_date(dates.type) or pa.types.is_timestamp(dates.type)):
        days = dates.cast(_STAMP).cast(pa.int64())
        return pc.add(days, times.cast(pa.time64("ns")).cast(pa.int64())).cast(_STAMP)
    return pc.binary_join_element_wise(*(each.cast(pa.string()) for each in (dates, times)), " ")


def _integers(values: pa.Array) -> Times:
    return np.asarray(values.cast(pa.int64()).to_numpy(zero_copy_only=False))


def _cast(values: pa.Array, kind: pa.DataType) -> pa.Array:
    """Times of another kind; BadCellError for the first that 64 bits do not hold."""
    try:
        return values.cast(kind)
    except pa.ArrowInvalid as error:
        row = next(row for row in range(len(values)) if not _fits(values.slice(row, 1), kind))
        raise BadCellError(row, "is further from 1970 than nanoseconds are counted, 292 years") from error


def _fits(values: pa.Array, kind: pa.DataType) -> bool:
    try:
        values.cast(kind)
    except pa.ArrowInvalid:
        return False
    return True


def _whole(values: pa.Array) -> Times | None:
    """The values where all of them are whole numbers, and written so."""
    if not (pa.types.is_string(values.type) or pa.types.is_integer(values.type)):
        return None
    try:
        found: Times = values.cast(pa.int64()).to_numpy(zero_copy_only=False)
    except pa.ArrowInvalid:
        return None
    return found


def _check_near(seconds: Floats) -> None:
    far = np.abs(seconds) > _FAR_S
    if far.any():
        row = int(np.argmax(far))
        said = f"is {seconds[row]:g} s, which no clock shows: is it in another unit?"
        raise BadCellError(row, f"{said} vsensor import --time-unit ms, us or ns tells it")


def _kind_of(text: str) -> pa.DataType:
    offset = text.endswith("Z") or "+" in text or text.count("-") > 2
    return pa.timestamp("ns", "UTC") if offset else _STAMP


def _first_bad(values: pa.Array, read: Callable[[str], object]) -> int:
    kind = None
    for row, told in enumerate(values.to_pylist()):
        try:
            read(told)
        except pa.ArrowInvalid:
            return row
        if kind is not None and _kind_of(told) != kind:
            return row
        kind = _kind_of(told)
    return 0
