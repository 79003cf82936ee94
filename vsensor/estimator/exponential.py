"""e^x in a form that the compiler makes vectors of, and to the same bits on every machine.

x = n ln 2 + r with n whole and |r| ≤ ln 2 / 2, so that e^x = 2^n e^r: the second factor by Taylor's
polynomial, the first by the bits of the exponent. Sums and products alone: no table, from which a vector
would be gathered one by one, and nothing that one processor rounds once and another twice.
"""

import math
from typing import Any

import numba
from llvmlite import ir  # type: ignore[import-untyped]
from numba.extending import intrinsic

from vsensor.jit import COMPILED, compiled

LEAST = -708.0
"""Below this nothing is left: e^x would have fewer digits than other numbers."""
_PER_POWER = 1 / math.log(2)
_POWER = float.fromhex("0x1.62e42fee00000p-1"), float.fromhex("0x1.a39ef35793c76p-33")
"""ln 2 in two parts, the first so short that n times it is exact."""
_WHOLE = 1.5 * 2.0**52
"""Added to a number, it leaves the nearest whole one in the last bits."""
_EXPONENT = 52
"""By so many bits n is moved to count among those of the exponent."""
_C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11, _C12, _C13 = (1 / math.factorial(k) for k in range(2, 14))


def _read_bits(_typing: Any, x: Any) -> Any:
    return numba.int64(x), lambda _context, builder, _signature, given: builder.bitcast(*given, _INTEGER)


def _make_number(_typing: Any, bits: Any) -> Any:
    return numba.float64(bits), lambda _context, builder, _signature, given: builder.bitcast(*given, _DOUBLE)


_INTEGER, _DOUBLE = ir.IntType(64), ir.DoubleType()
_bits: Any = intrinsic(_read_bits)
"""The bits of a number as a whole one,"""
_number: Any = intrinsic(_make_number)
"""and back."""


def _by_bits(x: float, shifted: float) -> float:
    return float(_number(_bits(x) + (_bits(shifted) << _EXPONENT)))


def _by_library(x: float, shifted: float) -> float:
    return math.ldexp(x, int(shifted - _WHOLE))


_times_power = compiled(_by_bits if COMPILED else _by_library)
"""x 2^n, n as it stands in the last bits of `shifted`."""


@compiled
def exponential(x: float) -> float:
    """e^x for x up to 708, within one place of the last."""
    if x < LEAST:
        return 0.0
    shifted = x * _PER_POWER + _WHOLE
    n = shifted - _WHOLE
    r = x - n * _POWER[0] - n * _POWER[1]
    # By pairs, and pairs of them (Estrin 1960): one after the other they would have to wait.
    square = r * r
    low = (_C2 + _C3 * r) + (_C4 + _C5 * r) * square
    middle = (_C6 + _C7 * r) + (_C8 + _C9 * r) * square
    high = (_C10 + _C11 * r) + (_C12 + _C13 * r) * square
    fourth = square * square
    beyond = low + (middle + high * fourth) * fourth
    return _times_power(1.0 + (r + square * beyond), shifted)
