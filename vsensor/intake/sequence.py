"""One channel's sequence numbers: a hole in them is a loss, until the missing one comes late after all."""

from typing import Any

from vsensor.saved import Saved

LONGEST_HOLE = 1_000_000
"""A greater leap in the sequence is another publisher's count, and no loss."""
REMEMBERED = 1000
"""How far back a missing sample's number is known, so that it is no loss if it only comes late."""


class Sequence:
    """What number is due, and which ones are missing."""

    def __init__(self) -> None:
        self.due: int | None = None
        self._missing: set[int] = set()
        self._unread = 0

    def follow(self, given: int, is_newest: bool) -> int:
        """Follow the next number; returns by how many more samples are lost, −1 for one that came late.

        `is_newest`: it was accepted, and no other's time is later.
        """
        unread, self._unread = self._unread, 0
        ahead = 0 if self.due is None else given - self.due
        if given in self._missing:
            self._missing.remove(given)
            return -1
        if 0 <= ahead <= LONGEST_HOLE:
            if ahead and not unread:  # which of them were unread is not known
                self._remember(given, ahead)
            self.due = given + 1
            return max(ahead - unread, 0)
        if ahead > 0 or (ahead < -1 and is_newest):
            # A low number with the newest time: the publisher has begun to count anew.
            self._missing.clear()
            self.due = given + 1
        return 0

    def pass_unread(self) -> None:
        """A sample was not looked at: the hole that it leaves is no loss."""
        self._unread += 1

    def _remember(self, given: int, missing: int) -> None:
        known = given - REMEMBERED
        self._missing = {number for number in self._missing if number >= known}
        self._missing.update(range(max(given - missing, known), given))

    def save(self) -> dict[str, Any]:
        """What is remembered, as plain values."""
        return {"next_sequence": self.due, "missing": sorted(self._missing)}

    def restore(self, saved: Saved) -> None:
        """Take up what `save` gave. Raises ValueError for what it cannot have given."""
        self.due = saved["next_sequence"].or_none(lambda given: given.whole(0, 1 << 64))
        missing = saved["missing"].rows()
        if len(missing) > REMEMBERED:
            raise saved["missing"].wrong(f"a list of {REMEMBERED} at the most")
        self._missing = {number.whole(0, (1 << 64) - 1) for number in missing}
