"""The newest minutes held in memory, so that what has just happened can still be kept."""

from collections import deque
from dataclasses import dataclass, field

from vsensor.recording import wire

MEMORY_BYTES = 256 << 20
"""Never more than this, however long was asked for."""


@dataclass(slots=True)
class Segment:
    """What came from one checkpoint to the next."""

    begun: float
    checkpoint: wire.Checkpoint
    packets: list[bytes] = field(default_factory=list)
    size: int = 0


class Memory:
    """Segments, oldest first, each of which can be run on its own; nothing is held before the first."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._segments: deque[Segment] = deque()
        self.size = 0

    def begin(self, checkpoint: wire.Checkpoint, now: float) -> None:
        """Begin a segment, and let go of those that are older than all that may be asked for."""
        if not self._seconds:
            return
        self._segments.append(Segment(now, checkpoint))
        self._grow(len(checkpoint.remembered))
        while len(self._segments) > 1 and (
            self._segments[1].begun <= now - self._seconds or self.size > MEMORY_BYTES
        ):
            self.size -= self._segments.popleft().size

    def add(self, packet: bytes) -> None:
        """Hold a packet, where something began that it belongs to."""
        if self._segments:
            self._segments[-1].packets.append(packet)
            self._grow(len(packet))

    def reach(self, now: float) -> float:
        """How far back a snapshot would go, s."""
        return now - self._segments[0].begun if self._segments else 0.0

    def newest(self, seconds: float, now: float) -> list[Segment]:
        """Copies of the segments that hold the last `seconds`, as far as they are there."""
        held = list(self._segments)
        while len(held) > 1 and held[1].begun <= now - seconds:
            del held[0]
        return [Segment(each.begun, each.checkpoint, each.packets.copy()) for each in held]

    def _grow(self, size: int) -> None:
        self._segments[-1].size += size
        self.size += size
