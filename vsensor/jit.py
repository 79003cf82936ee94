"""How the kernels are compiled: cached on disk, without fast-math, without memory of their own.

Numba keys a cached kernel by its own file alone, so that a change in a kernel that it calls would go
unseen. Ours are therefore cached in a folder named for the whole of what is compiled into them.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

import numba
import platformdirs

P = ParamSpec("P")
R = TypeVar("R")

_KERNELS = Path(__file__).parent / "estimator"


def _cache_folder() -> Path:
    sources = hashlib.sha256()
    for file in (*sorted(_KERNELS.glob("*.py")), _KERNELS.parent / "quality.py", Path(__file__)):
        sources.update(file.read_bytes())
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    base = Path(chosen) if chosen else Path(platformdirs.user_cache_dir("vsensor"))
    return base / f"kernels-{sources.hexdigest()[:16]}"


numba.config.CACHE_DIR = str(_cache_folder())  # type: ignore[attr-defined]


COMPILED = not numba.config.DISABLE_JIT  # type: ignore[attr-defined]
"""Whether kernels are compiled at all: tests run them as they stand, too."""


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel at its first call, or load it from the cache.

    Fast-math stays off: it lets the compiler assume that there is no NaN, and reorder sums, which
    would end both the checks on input and the exactness of a replay. A kernel that would allocate is
    refused by the compiler: without its run-time for memory no references are counted either, which took
    half of the observer's time. A division by zero gives what IEEE 754 says, and raises nothing: to look
    for it would keep loops from becoming vectors. In the place of each call of a kernel stands the kernel
    itself: a call hands on all of a state's arrays word by word, which took a fifth of the tick.
    """
    return _njit(function)


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a part of kernels, which they alone call: from Python a call of it would crash.

    Without what Python calls it by, which is larger than most parts are: that took two fifths of the time
    that all kernels take to compile.
    """
    return _njit(function, no_cpython_wrapper=True)


def _njit(function: Callable[P, R], **more: bool) -> Callable[P, R]:
    options = {
        "cache": True,
        "_nrt": False,
        "error_model": "numpy",
        "forceinline": True,
        "no_cfunc_wrapper": True,
    }
    kernel: Callable[P, R] = numba.njit(**options, **more)(function)  # type: ignore[call-overload]
    return kernel
