"""What the stream is made of: parts that each hear the messages and draw one thing."""

from abc import ABC, abstractmethod
from collections.abc import Iterator

from vsensor.messages import Description, Message, Profile
from vsensor.view.batches import Batch

FIGURES_EVERY_NS = 250_000_000
"""Figures that change more often cannot be read."""


class Part(ABC):
    """One thing that is drawn."""

    at_ns = 0
    """The newest time of the source's clock."""

    def hear(self, message: Message, at_ns: int) -> None:
        """Take in one message at a time; those that do not concern it are passed over."""
        self.at_ns = at_ns
        self.take(message)

    @abstractmethod
    def take(self, message: Message) -> None:
        """Take in one message."""

    @abstractmethod
    def batches(self) -> Iterator[Batch]:
        """Hand over what there is to draw since the last call."""


class AlongString(Part):
    """One that is drawn of the newest profile, and of what the string is."""

    def __init__(self) -> None:
        self._description = Description()
        self._profile = Profile()

    def take(self, message: Message) -> None:
        """Take in a profile, or what the string is."""
        if isinstance(message, Description):
            self._description = message
        elif isinstance(message, Profile):
            self._profile = message


class Every:
    """Says when something is due again, on the source's clock."""

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._next_ns: int | None = None

    def due(self, at_ns: int) -> bool:
        """Whether the period is over; if so, the next begins."""
        if self._next_ns is not None and at_ns < self._next_ns:
            return False
        self._next_ns = at_ns + self._period_ns
        return True


class Beat:
    """Says when another period of the source's clock has begun: to all who ask, at the same moment."""

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._last = -1

    def due(self, at_ns: int) -> bool:
        """Whether it is another period than when it was asked last."""
        last, self._last = self._last, at_ns // self._period_ns
        return self._last != last
