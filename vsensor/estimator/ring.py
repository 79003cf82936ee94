"""Rings by internal step: what belongs to a step stands at its last bits, as many as there is room for.

Of many rings the newest numbers are asked for together. Did they lie a power of two apart, a processor's
cache would have one and the same place for all of them, and let one drive out the other.
"""

from vsensor.jit import compiled

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
