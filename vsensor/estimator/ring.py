"""Rings by internal step: what belongs to a step stands at its last bits, as many as there is room for.

Of many rings the newest numbers are asked for together. Did they lie a power of two apart, a processor's
cache would have one and the same place for all of them, and let one drive out the other.
"""

from vsensor.estimator.sections import Floats
from vsensor.jit import compiled, inlined

SPARE = 8
"""So many numbers, a line of the cache, stand unused behind the power of two of a ring."""


def length_of(steps: int) -> int:
    """The length of a ring that holds more than so many steps."""
    return (1 << int(steps).bit_length()) + SPARE


@compiled
def room_of(length: int) -> int:
    """For how many steps a ring of this length has room."""
    return length - SPARE


@compiled
def mask_of(length: int) -> int:
    """Which bits of a step tell its place in a ring of this length."""
    return length - SPARE - 1


@inlined
def weighted(run: Floats, steps: int, values: Floats) -> float:
    """Sum of values (n,), each by one of a run that is read backwards from its last, every so many `steps`.

    In four sums, which wait less for one another.
    """
    a = b = c = d = 0.0
    last = run.shape[0] - 1
    fours = values.shape[0] // 4
    for four in range(fours):
        k = 4 * four
        a += run[last - k * steps] * values[k]
        b += run[last - (k + 1) * steps] * values[k + 1]
        c += run[last - (k + 2) * steps] * values[k + 2]
        d += run[last - (k + 3) * steps] * values[k + 3]
    for k in range(4 * fours, values.shape[0]):
        a += run[last - k * steps] * values[k]
    return a + b + c + d
