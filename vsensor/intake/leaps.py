"""What is a leap in a channel: a change from one sample to the next far beyond what is usual for it.

What is usual is told by the channel itself: what nine in ten of its last changes stayed within. Wild values,
as long as they are fewer than one in ten, do not make it any larger, however large they are. A sensor that is
noisier than configured, or a slow one that sees the signal itself from one sample to the next, is doubted
until seven changes have shown it, in the first of its blocks. It is made of picked values, not of sums, so
that samples by columns come to the very same.
"""

from bisect import insort
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.saved import Saved

BLOCK = 64
"""Changes from which it is told what is usual for the next as many."""
OFTEN = 7
"""So many of them: no leaps any more, but usual."""
NOISES = 10.0
"""A change within so many standard deviations of the configured noise is no leap;"""
USUALS = 5.0
"""nor one within so many times what is usual. Of noise as configured the two say much the same;"""
TRIFLE = 1e-3
"""nor one within so small a part of what is believed at all, where next to no noise is configured."""


class Looked(NamedTuple):
    """What comes of n values."""

    changes: NDArray[np.float64]
    """To each, from the last before it that was none of the strays."""
    strays: NDArray[np.bool_]
    """Which ones leap and are not borne out by the next."""


class Leaps:
    """What is usual for one channel's changes, and which one is a leap."""

    def __init__(self, noise: float, limit: float) -> None:
        self._least = max(NOISES * noise, TRIFLE * limit)
        self._farthest = 2 * limit
        self.forget()

    def forget(self) -> None:
        """Begin anew."""
        self._count = 0
        self._largest = [0.0] * OFTEN
        """Of the block so far, ascending."""
        self._look_back(0.0)

    def is_one(self, change: float) -> bool:
        """Whether a change, 0 or more, is a leap."""
        return change > self._beyond and change > USUALS * self._largest[0]

    def note(self, change: float) -> None:
        """Take account of the next change, a leap or not."""
        largest = self._largest
        if change > largest[0]:
            del largest[0]
            insort(largest, change)
        self._count += 1
        if self._count == BLOCK:
            self._look_back(largest[0])
            self._count, self._largest = 0, [0.0] * OFTEN

    def _look_back(self, usual: float) -> None:
        self._usual = usual
        self._beyond = max(self._least, USUALS * usual)

    def look(self, values: NDArray[np.float64]) -> "Looked | None":
        """What comes of the next n values, shape (n + 1,) with the one before them.

        None where they must be looked at one by one: where a leap is borne out, or a stray is not alone.
        """
        changes = np.abs(np.diff(values))
        strays = np.zeros(len(changes), np.bool_)
        if float(changes.max(initial=0.0)) <= self._least:
            return Looked(changes, strays)
        back = np.abs(values[2:] - values[:-2])
        strays[:-1] = (changes[:-1] > self._least) & (changes[1:] >= back)
        if np.any(strays[1:] & strays[:-1]):
            return None
        behind = np.flatnonzero(strays) + 1
        changes[behind] = back[behind - 1]
        return Looked(changes, strays) if self._are_those(changes, strays) else None

    def _are_those(self, changes: NDArray[np.float64], strays: NDArray[np.bool_]) -> bool:
        """Whether all strays leap, and the others do not."""
        told = self._with_held(changes)
        blocks = np.append(told, np.zeros(-len(told) % BLOCK)).reshape(-1, BLOCK)
        usual = USUALS * np.partition(blocks, BLOCK - OFTEN, axis=1)[:, BLOCK - OFTEN]
        beyond = np.append(self._beyond, np.maximum(self._least, usual[:-1]))
        # Less would do: what is usual in its own block is not all known when a stray comes, or waits.
        surely = np.maximum(beyond, usual)
        own = slice(self._count, len(told))
        within = changes <= np.repeat(beyond, BLOCK)[own]
        return bool(np.all(np.where(strays, changes > np.repeat(surely, BLOCK)[own], within)))

    def note_all(self, changes: NDArray[np.float64]) -> None:
        """Take account of the next n changes, shape (n,)."""
        told = self._with_held(changes)
        end = len(told) // BLOCK * BLOCK
        if end:
            self._look_back(float(np.sort(told[end - BLOCK : end])[-OFTEN]))
        self._count = len(told) - end
        self._largest = sorted([0.0] * OFTEN + told[end:].tolist())[-OFTEN:]

    def _with_held(self, changes: NDArray[np.float64]) -> NDArray[np.float64]:
        """Those of the block so far, as large as need be known, and the next."""
        held = ([0.0] * BLOCK + self._largest)[-self._count :] if self._count else []
        return np.append(held, changes)

    def save(self) -> dict[str, Any]:
        """What is remembered, as plain values."""
        return {"usual": self._usual, "count": self._count, "largest": self._largest}

    def restore(self, saved: Saved) -> None:
        """Take up what `save` gave. Raises ValueError for what it cannot have given."""
        self._look_back(saved["usual"].number(0.0, self._farthest))
        self._count = saved["count"].whole(0, BLOCK - 1)
        self._largest = [change.number(0.0, self._farthest) for change in saved["largest"].row(OFTEN)]
        most = min(self._count, OFTEN)
        if self._largest != sorted(self._largest) or any(self._largest[: OFTEN - most]):
            raise saved["largest"].wrong(f"a list in ascending order with no more than {most} that are not 0")
