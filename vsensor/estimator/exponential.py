"""e^x, to the bits of the C library's, in a form that the compiler makes vectors of.

x = (n + r) ln 2 / 128 with n whole and |r| ≤ 1/2, so that e^x = 2^(n/128) e^(r ln 2 / 128): the first factor
from a table, the second by a polynomial (Tang 1989). Polynomial and order of the sums are those of ARM's
optimized routines, which glibc took up in 2.28.
"""

import math
import platform
from collections.abc import Callable
from decimal import Context, Decimal
from typing import Any

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from llvmlite.binding import get_host_cpu_features  # type: ignore[import-untyped]
from numba.extending import intrinsic

from vsensor.jit import COMPILED, compiled

LEAST = -708.0
"""Below this nothing is left: e^x would have fewer digits than other numbers."""
_PIECES = 128
_PER_PIECE = float.fromhex("0x1.71547652b82fep+7")
_PIECE = float.fromhex("0x1.62e42fefa0000p-8"), float.fromhex("0x1.cf79abc9e3b3ap-47")
"""128 / ln 2; and ln 2 / 128 in two parts, the first so short that n times it is exact."""
_C2, _C3, _C4, _C5 = map(
    float.fromhex,
    ("0x1.ffffffffffdbdp-2", "0x1.555555555543cp-3", "0x1.55555cf172b91p-5", "0x1.1111167a4d017p-7"),
)
_WHOLE = 1.5 * 2.0**52
"""Added to a number, it leaves the nearest whole one in the last bits."""
_EXPONENT = 52 - 7
"""By so many bits n is moved to count among those of the exponent, 128 to each."""


def _table() -> tuple[
    np.ndarray[tuple[int], np.dtype[np.int64]], np.ndarray[tuple[int], np.dtype[np.float64]]
]:
    """The bits of 2^(k/128), less what k itself adds to the exponent; and the share that was rounded away."""
    exact = Context(prec=50)
    step = exact.divide(exact.ln(Decimal(2)), _PIECES)
    powers = [exact.exp(exact.multiply(step, k)) for k in range(_PIECES)]
    near = np.array([float(power) for power in powers])
    rest = np.array([float(exact.divide(power, Decimal(float(power))) - 1) for power in powers])
    return near.view(np.int64) - (np.arange(_PIECES) << _EXPONENT), rest


_NEAR, _REST = _table()


def _fuse(_typing: Any, a: Any, b: Any, c: Any) -> Any:
    return numba.float64(a, b, c), lambda _context, builder, _signature, given: builder.fma(*given)


def _read_bits(_typing: Any, x: Any) -> Any:
    return numba.int64(x), lambda _context, builder, _signature, given: builder.bitcast(*given, _INTEGER)


def _make_number(_typing: Any, bits: Any) -> Any:
    return numba.float64(bits), lambda _context, builder, _signature, given: builder.bitcast(*given, _DOUBLE)


_INTEGER, _DOUBLE = ir.IntType(64), ir.DoubleType()
_fused: Any = intrinsic(_fuse)
"""a b + c of three numbers, rounded once."""
_bits: Any = intrinsic(_read_bits)
"""The bits of a number as a whole one,"""
_number: Any = intrinsic(_make_number)
"""and back."""


def _by_table(x: float) -> float:
    """e^x for x up to 708."""
    if x < LEAST:
        return 0.0
    shifted = _fused(x, _PER_PIECE, _WHOLE)
    n = _bits(shifted)
    whole = shifted - _WHOLE
    r = _fused(whole, -_PIECE[1], _fused(whole, -_PIECE[0], x))
    square = r * r
    more = _fused(_fused(r, _C3, _C2), square, _REST[n & (_PIECES - 1)] + r)
    more = _fused(square * square, _fused(r, _C5, _C4), more)
    power = _number(_NEAR[n & (_PIECES - 1)] + (n << _EXPONENT))
    return float(_fused(power, more, power))


def _by_library(x: float) -> float:
    return math.exp(x) if x >= LEAST else 0.0


def _fuses() -> bool:
    """Whether the processor multiplies and adds in one: where not, each sum of it would be a call."""
    x86 = platform.machine().lower() in ("x86_64", "amd64")
    return COMPILED and (not x86 or bool(get_host_cpu_features()["fma"]))


exponential: Callable[[float], float] = compiled(_by_table if _fuses() else _by_library)
"""e^x for x up to 708, with glibc's own bits above −512."""
