"""One channel's sequence numbers: a hole in them is a loss, until the missing one comes late after all.

Where two publishers tell one channel their counts take turns, and neither has lost what the other told.
"""

from typing import Any

from vsensor.saved import Saved

LONGEST_HOLE = 1_000_000
"""A greater leap in the sequence is another publisher's count, and no loss."""
REMEMBERED = 1000
"""How far back a missing sample's number is known, so that it is no loss if it only comes late."""
TURNS = 3
"""So many returns to a count that was left: two publishers, each with its own,"""
QUIET = 200
"""until so many samples have come in one count."""
_LAST = 1 << 64


class Sequence:
    """What number is due, and which ones are missing."""

    def __init__(self) -> None:
        self.due: int | None = None
        self._missing: set[int] = set()
        self._unread = 0
        self._leave(None, 0)
        self._turns = 0

    def _leave(self, due: int | None, taken: int) -> None:
        """Go on in another count: in this one `due` was next, and for the leap `taken` were called lost."""
        self._left, self._taken, self._quiet = due, taken, 0

    @property
    def contested(self) -> bool:
        """Whether two publishers take turns."""
        return self._turns == TURNS

    def follow(self, given: int, is_newest: bool) -> int:
        """Follow the next number; returns by how many more samples are lost, less than 0 for what was not.

        `is_newest`: it was accepted, and no other's time is later.
        """
        unread, self._unread = self._unread, 0
        ahead = 0 if self.due is None else given - self.due
        if ahead == 0:
            self.pass_over(given, 1)
            return 0
        if given in self._missing:
            self._missing.remove(given)
            if is_newest:  # late it is not
                self._turn()
            return -1
        left = self._left
        if left is not None and 0 <= given - left <= REMEMBERED and (ahead > 0 or is_newest):
            return self._return(given, max(given - left - unread, 0))
        if 0 < ahead <= LONGEST_HOLE:
            lost = max(ahead - unread, 0)
            if ahead > REMEMBERED:
                self._leave(self.due, lost)
            if not unread:  # which of them were unread is not known
                self._remember(given, ahead)
            self.due = given + 1
            return lost
        if ahead > 0 or (ahead < -1 and is_newest):
            # A low number with the newest time: the publisher has begun to count anew.
            self._missing.clear()
            self._leave(self.due, 0)
            self.due = given + 1
        return 0

    def pass_over(self, last: int, count: int) -> None:
        """Follow so many numbers in turn, of which this is the last."""
        self.due = last + 1
        if self._left is not None or self._turns:
            self._quiet += count
            if self._quiet >= QUIET:
                self._leave(None, 0)
                self._turns = 0

    def pass_unread(self) -> None:
        """A sample was not looked at: the hole that it leaves is no loss."""
        self._unread += 1

    def _return(self, given: int, lost: int) -> int:
        """The count that was left goes on: what the leap to the other seemed to have lost was not."""
        more = lost - self._taken
        self._missing.clear()
        self._leave(self.due, 0)
        self.due = given + 1
        self._turn()
        return more

    def _turn(self) -> None:
        self._turns, self._quiet = min(self._turns + 1, TURNS), 0

    def _remember(self, given: int, missing: int) -> None:
        known = given - REMEMBERED
        self._missing = {number for number in self._missing if number >= known}
        self._missing.update(range(max(given - missing, known), given))

    def save(self) -> dict[str, Any]:
        """What is remembered, as plain values."""
        return {
            "next_sequence": self.due,
            "missing": sorted(self._missing),
            "counts": [self._left, self._taken, self._turns, self._quiet],
        }

    def restore(self, saved: Saved) -> None:
        """Take up what `save` gave. Raises ValueError for what it cannot have given."""
        self.due = saved["next_sequence"].or_none(lambda given: given.whole(0, _LAST))
        missing = saved["missing"].rows()
        if len(missing) > REMEMBERED:
            raise saved["missing"].wrong(f"a list of {REMEMBERED} at the most")
        self._missing = {number.whole(0, _LAST - 1) for number in missing}
        self._leave(None, 0)
        self._turns = 0
        saved.get("counts", None).or_none(self._restore_counts)

    def _restore_counts(self, saved: Saved) -> None:
        left, taken, turns, quiet = saved.row(4)
        self._leave(left.or_none(lambda given: given.whole(0, _LAST)), taken.whole(0, LONGEST_HOLE))
        self._turns, self._quiet = turns.whole(0, TURNS), quiet.whole(0, QUIET - 1)
