"""What has happened, in words, and the page of answers."""

from collections.abc import Iterator

from vsensor.messages import Estimate, Event, Message, Status
from vsensor.messages.states import RUNNING
from vsensor.view import series, words
from vsensor.view.batches import Batch, LogLine, Page
from vsensor.view.part import FIGURES_EVERY_NS, Beat, Part
from vsensor.view.units import Units


class Journal(Part):
    """The log of events and of the sensor's states; the answers in figures."""

    def __init__(self, units: Units) -> None:
        self._units = units
        self._status = Status()
        self._estimate = Estimate()
        self._out: list[Batch] = []
        self._beat = Beat(FIGURES_EVERY_NS)

    def take(self, message: Message) -> None:
        """Take in one message."""
        match message:
            case Estimate():
                self._estimate = message
            case Status():
                if message.state != self._status.state:
                    level = "INFO" if message.state == RUNNING else "WARN"
                    self._log(self.at_ns, level, f"{words.clock(self.at_ns)} sensor: {message.state}")
                self._status = message
            case Event():
                self._log(message.time_ns, *words.told(message))

    def silent(self, seconds: float, at_ns: int) -> None:
        """Say that nothing has come for so long."""
        self._out.append(Page(series.PAGE, at_ns, words.silence(seconds)))

    def batches(self) -> Iterator[Batch]:
        """Hand over what has come since the last call."""
        out, self._out = self._out, []
        yield from out
        if (
            self._status.state
            and not any(isinstance(batch, Page) for batch in out)
            and self._beat.due(self.at_ns)
        ):
            yield Page(series.PAGE, self.at_ns, words.answers(self._estimate, self._status, self._units))

    def _log(self, time_ns: int, level: str, text: str) -> None:
        self._out.append(LogLine(series.LOG, time_ns, level, text))
