"""Spectra over the ticks of a long record: what is caused, what is told, and how much is left."""

import numpy as np
from numpy.typing import NDArray

from vsensor.estimator.sections import Floats

Complexes = NDArray[np.complex128]


def factorised(spectrum: Floats) -> tuple[float, Complexes]:
    """Innovation variance s and H of a spectrum s |H|²: the causal half of the logarithm's transform."""
    ticks = 2 * (len(spectrum) - 1)
    cepstrum = np.fft.irfft(np.log(spectrum), ticks)
    variance = float(np.exp(cepstrum[0]))
    cepstrum[0] = 0.0
    cepstrum[ticks // 2] *= 0.5
    cepstrum[ticks // 2 + 1 :] = 0.0
    return variance, np.exp(np.fft.rfft(cepstrum, ticks))


def before(squares: Floats, start: int) -> Floats:
    """Sum of squares (…, ticks) before tick `start`: of innovations that are still to come by then."""
    ticks = squares.shape[-1]
    past = squares[..., ticks // 2 : ticks + min(start, 0)].sum(axis=-1)
    return np.asarray(past + squares[..., : max(start, 0)].sum(axis=-1))


def half_told(share: Floats, rate: float) -> float:
    """The highest frequency below which the rock makes more than half of what is seen, Hz."""
    lost = np.flatnonzero(share[1:] < 0.5)
    first = int(lost[0]) if len(lost) else len(share) - 1
    return first * rate / (2 * (len(share) - 1))


def rounded(column: Floats, *, by_itself: bool = False) -> Floats:
    """Each row to 26 bits of its greatest number, or each number to 26 bits of itself.

    The last bits of transforms and logarithms differ between processors; a session must come out the
    same on each.
    """
    greatest = np.abs(column) if by_itself else np.abs(column).max(axis=-1, keepdims=True)
    grid = np.ldexp(1.0, np.frexp(greatest)[1] - 26)
    return np.asarray(np.rint(column / grid) * grid, np.float64)
