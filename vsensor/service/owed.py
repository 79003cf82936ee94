"""Ticks that are owed for slots that were skipped: those that are made up for say so."""

from vsensor.service.pace import Slot

OWED_S = 5.0
"""So long after slots were skipped their samples may come: links that have ended are back by then."""


class Owed:
    """How many ticks are owed. What has not come some seconds later never was."""

    def __init__(self, rate_hz: float) -> None:
        self._for_slots = round(OWED_S * rate_hz)
        self._count = 0
        self._until = 0

    def turn(self, slot: Slot) -> None:
        """A turn begins: a tick is owed for each slot that was skipped before it."""
        if slot.skipped:
            self._count += slot.skipped
            self._until = slot.number + self._for_slots
        elif slot.number > self._until:
            self._count = 0

    def pay(self) -> bool:
        """A tick was run: whether it is one of those that are owed."""
        owed = self._count > 0
        self._count -= owed
        return owed
