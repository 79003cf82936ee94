"""Times as tables have them, in nanoseconds: numbers in any unit, ISO 8601, date and time apart."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from typing import Self
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from vsensor.errors import ConfigError
from vsensor.grid import NS
from vsensor.tables.cells import BadCellError, Floats, as_floats, filled, numbers
from vsensor.units import factor

Times = npt.NDArray[np.int64]

_FAR_S = 9e9
"""Nanoseconds since 1970 fit 64 bits until 2262; milliseconds taken for seconds do not."""
_EXACT = {"s": NS, "ms": 1_000_000, "us": 1000, "µs": 1000, "ns": 1}
"""Units of which whole numbers are so many whole nanoseconds."""
_DATE = r"^(\d{4})[-/.]?(\d{2})[-/.]?(\d{2})", r"\1-\2-\3"
"""2026-11-24, 2026/11/24, 2026.11.24 and 20261124 are one date."""
_STAMP = pa.timestamp("ns")
_YEAR = re.compile(r"%[YyGcx]")
"""What a pattern tells a year by: without, strptime takes 1900, and a session's clock begins with 1970."""


@dataclass(frozen=True)
class TimeForm:
    """How a table tells the time.

    `unit` is that of a column of numbers; `pattern` that of text which is not ISO 8601, as strptime has it;
    `zone` where the clock hangs that tells no offset of its own.
    """

    unit: str = "s"
    pattern: str = ""
    zone: str = "UTC"

    def checked(self) -> Self:
        """The same; ConfigError for a unit or a zone that is none, whether or not a table asks for it."""
        _ = self._nanoseconds
        if self.zone != "UTC":  # times in numbers need no list of zones, which a machine may lack
            _ = self._hangs
        return self

    def read(self, values: pa.Array, dates: pa.Array | None = None) -> Times:
        """A column of times, or of times of day with its dates, in nanoseconds; shape (n,).

        Raises BadCellError for the first that is none, ConfigError for a unit or a zone that is none.
        """
        values = filled(values)
        if dates is not None:
            values = _joined(filled(dates), values)
        kind = values.type
        if pa.types.is_timestamp(kind) or pa.types.is_date(kind):
            return self._stamps(
                values.cast(pa.timestamp("ns", kind.tz if pa.types.is_timestamp(kind) else None))
            )
        if pa.types.is_string(kind) and (self.pattern or as_floats(values[:1]) is None):
            return self._by_pattern(values) if self.pattern else self._iso(values)
        return self._counted(values)

    @cached_property
    def _nanoseconds(self) -> float:
        try:
            return factor(self.unit, "s") * NS
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
        exact, whole = _EXACT.get(self.unit), _whole(values)
        if exact and whole is not None:
            _check_near(whole / (NS / exact))
            return whole * exact
        found = numbers(values) * (self._nanoseconds / NS)
        _check_near(found)
        seconds = np.floor(found)
        # Apart from the rest: a double that counts nanoseconds since 1970 knows them to 256.
        return seconds.astype(np.int64) * NS + np.rint((found - seconds) * 1e9).astype(np.int64)

    def _iso(self, text: pa.Array) -> Times:
        text = pc.replace_substring_regex(text, *_DATE)
        for kind in (_STAMP, pa.timestamp("ns", "UTC")):
            try:
                return self._stamps(text.cast(kind))
            except pa.ArrowInvalid:
                continue
        row = _first_bad(text, lambda told: self._stamps(pa.array([told]).cast(_kind_of(told))))
        raise BadCellError(
            row, f"is {text[row].as_py()!r}: a time such as 2026-11-24T08:15:30.25 was expected"
        )

    def _by_pattern(self, text: pa.Array) -> Times:
        found = np.empty(len(text), np.int64)
        without_year = not _YEAR.search(self.pattern)
        for row, told in enumerate(text.to_pylist()):
            try:
                time = datetime.strptime(told, self.pattern)
            except ValueError as error:
                raise BadCellError(
                    row, f"is {told!r}: a time of the form {self.pattern!r} was expected"
                ) from error
            if without_year:
                time = time.replace(year=1970)
            known = time if time.tzinfo else time.replace(tzinfo=self._hangs)
            since = known - datetime(1970, 1, 1, tzinfo=UTC)
            found[row] = (since.days * 86_400 + since.seconds) * NS + since.microseconds * 1000
        return found

    def _stamps(self, stamps: pa.Array) -> Times:
        if stamps.type.tz is None:
            stamps = pc.assume_timezone(stamps, self._hangs.key, ambiguous="earliest", nonexistent="latest")
        return np.asarray(stamps.cast(pa.int64()).to_numpy(zero_copy_only=False))


IN_SECONDS = TimeForm()


def _joined(dates: pa.Array, times: pa.Array) -> pa.Array:
    if pa.types.is_time(times.type) and (pa.types.is_date(dates.type) or pa.types.is_timestamp(dates.type)):
        days = dates.cast(_STAMP).cast(pa.int64())
        return pc.add(days, times.cast(pa.time64("ns")).cast(pa.int64())).cast(_STAMP)
    return pc.binary_join_element_wise(*(each.cast(pa.string()) for each in (dates, times)), " ")


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
        raise BadCellError(row, f"is {seconds[row]:g} s, which no clock shows: is it in another unit?")


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
