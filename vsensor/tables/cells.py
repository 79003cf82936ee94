"""What stands in a table's cells, as numbers; and which cell it is that holds none."""

import re
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

_THOUSANDS = re.compile(r"[+-]?\d{1,3}([,.' \u00a0]\d{3})+[,.]\d+|[+-]?\d{1,3}([,.' \u00a0]\d{3}){2,}")
"""A number with marks between its thousands."""
_WITH_COMMA = re.compile(r"[+-]?\d+,\d+")
"""As half of Europe writes a number."""
Floats = npt.NDArray[np.float64]


class BadCellError(ValueError):
    """A row (from 0), and what is wrong with what stands there."""

    def __init__(self, row: int, fault: str) -> None:
        super().__init__(fault)
        self.row = row


def numbers(values: pa.Array) -> Floats:
    """A column's values as finite numbers. Raises BadCellError for the first that is none."""
    found = measured(filled(values))
    _refuse(np.isnan(found), found)
    return found


def measured(values: pa.Array) -> Floats:
    """What was measured, NaN where a cell is empty or says so. Raises BadCellError for what is none."""
    found = as_told(values)
    _refuse(np.isinf(found), found)
    return found


def as_told(values: pa.Array) -> Floats:
    """The same of a source that may say that it is infinite. Raises BadCellError for what is no number."""
    values = _plain(values)
    if pa.types.is_string(values.type):
        of_text = as_floats(values)
        if of_text is None:
            row, text = next((i, v) for i, v in enumerate(values.to_pylist()) if not _is_number(v))
            asked = "a finite number"
            if _WITH_COMMA.fullmatch(text):
                asked += f" with a point, such as {text.replace(',', '.')},"
            if _THOUSANDS.fullmatch(text):
                asked += " without marks between thousands"
            raise BadCellError(row, f"is {text!r}: {asked} was expected")
        found = of_text
    elif is_number(values.type) or pa.types.is_null(values.type):
        found = values.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
    else:
        raise BadCellError(0, f"is of type {values.type}: a finite number was expected")
    return found


def blanked(values: pa.Array, nulls: Sequence[float]) -> pa.Array:
    """A column, empty where it holds one of `nulls`. Raises BadCellError for what is no number."""
    if not nulls:
        return values
    values = _plain(values)
    # Of 32 bits -999.1 is another number than of 64.
    kind = values.type.to_pandas_dtype() if pa.types.is_floating(values.type) else np.float64
    nothing = np.isin(as_told(values), np.array(nulls).astype(kind))
    return pc.if_else(pa.array(nothing), pa.scalar(None, values.type), values)


def filled(values: pa.Array) -> pa.Array:
    """A column, text without the spaces around it. Raises BadCellError for the first cell that is empty."""
    values = _plain(values)
    if values.null_count:
        raise BadCellError(pc.index(values.is_null(), True).as_py(), "is empty")
    return values


def _plain(values: pa.Array) -> pa.Array:
    """A column without a dictionary, text in one type, spaces around it taken off; blank is nothing."""
    if pa.types.is_dictionary(values.type):
        values = values.dictionary_decode()
    if pa.types.is_large_string(values.type) or pa.types.is_string_view(values.type):
        values = values.cast(pa.string())
    if pa.types.is_string(values.type):
        values = pc.utf8_trim_whitespace(values)
        values = pc.if_else(pc.equal(values, ""), None, values)
    return values


def _refuse(wrong: npt.NDArray[np.bool_], found: Floats) -> None:
    if wrong.any():
        row = int(np.argmax(wrong))
        raise BadCellError(row, f"is {found[row]}: a finite number was expected")


def as_floats(text: pa.Array) -> Floats | None:
    """Text as numbers; None where any of it is none."""
    try:
        found: Floats = text.cast(pa.float64()).to_numpy(zero_copy_only=False)
    except pa.ArrowInvalid:
        return None
    return found


def is_number(kind: pa.DataType) -> bool:
    """Whether a column's type is one of numbers."""
    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind))


def is_text(cell: str) -> bool:
    """Whether a cell holds something else than a number."""
    return not _is_number(cell.strip())


def _is_number(text: str) -> bool:
    try:
        pa.scalar(text).cast(pa.float64())
    except pa.ArrowInvalid:
        return False
    return True
