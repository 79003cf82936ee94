"""What waits between the thread that receives and the one that writes."""

import threading

from vsensor.recording import wire

Item = bytes | wire.Checkpoint | wire.Heading


class Backlog:
    """Packets and checkpoints in their order, bounded in bytes."""

    def __init__(self, capacity: int) -> None:
        self.dropped = 0
        """Messages, not packets."""
        self.most = 0
        """The most bytes that have waited since this was set back to 0."""
        self.ended = threading.Event()
        self._capacity = capacity
        self._held = 0
        self._items: list[Item] = []
        self._lock = threading.Lock()

    def put(self, item: Item) -> None:
        """Add an item; where there is no room, count a packet's messages as dropped."""
        size = _size(item)
        with self._lock:
            if self._held + size <= self._capacity:
                self._items.append(item)
                self._held += size
                self.most = max(self.most, self._held)
                return
        if isinstance(item, bytes):
            self.dropped += sum(1 for _ in wire.unpack(item))

    def take(self) -> list[Item]:
        """Take all that is there, in order."""
        with self._lock:
            items, self._items, self._held = self._items, [], 0
        return items


def _size(item: Item) -> int:
    match item:
        case wire.Checkpoint():
            return len(item.remembered)
        case wire.Heading():
            return 0  # there are few, and none may be lost
    return len(item)
