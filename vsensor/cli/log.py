"""What the daemon says: an event and its fields, for a person at a terminal or for whoever collects logs."""

import contextlib
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, MutableMapping
from contextlib import contextmanager
from enum import StrEnum
from queue import Empty, Full, Queue
from typing import Any, TextIO

import structlog
from structlog.dev import ConsoleRenderer
from structlog.processors import JSONRenderer, LogfmtRenderer, TimeStamper, add_log_level
from structlog.typing import FilteringBoundLogger

from vsensor.bus.allowance import Allowance
from vsensor.cli.printable import printable
from vsensor.commands import COMMAND, SNAPSHOT

Line = MutableMapping[str, Any]

PER_SECOND = 0.1
BURST = 5
"""Lines of one kind: five at once and then one in ten seconds, however often it happens."""
OWN_ACTS = ("configuration", COMMAND, SNAPSHOT)
OWN_PER_SECOND = 1.0
OWN_BURST = 100
"""What answers somebody's own act has an allowance that nobody uses up by hand."""
LATE_S = 1.0
"""How often is looked whether a line that was held back may be written."""

WAITING = 1000
"""Lines that may wait for whoever reads them."""
FAREWELL_S = 2.0


class Form(StrEnum):
    """How a line is written."""

    AUTO = "auto"
    TEXT = "text"
    LOGFMT = "logfmt"
    JSON = "json"


class Restraint:
    """Holds back lines of a kind that come too often: the last of them is written late, the rest counted.

    Of an event its beginnings are one kind, its ends another.
    """

    def __init__(self) -> None:
        self._allowances: dict[tuple[str, object], Allowance] = {}
        self._suppressed: Counter[str] = Counter()
        self._held: dict[str, Line] = {}

    def take(self, line: Line, now_ns: int) -> Iterator[Line]:
        """Let a line pass, or hold it back."""
        event = str(line["event"])
        self._suppressed[event] += self._held.pop(event, None) is not None
        if self._allowed(line, now_ns):
            yield self._counted(line)
        else:
            self._held[event] = line

    def late(self, now_ns: int) -> Iterator[Line]:
        """Those that were held back and may be written now."""
        for event, line in list(self._held.items()):
            if self._allowed(line, now_ns):
                yield self._counted(self._held.pop(event))

    def rest(self) -> Iterator[Line]:
        """Those that are held back still."""
        yield from map(self._counted, self._held.values())

    def _allowed(self, line: Line, now_ns: int) -> bool:
        event = str(line["event"])
        limits = (OWN_PER_SECOND, OWN_BURST) if event in OWN_ACTS else (PER_SECOND, BURST)
        return self._allowances.setdefault((event, line.get("begins")), Allowance(*limits)).take(now_ns)

    def _counted(self, line: Line) -> Line:
        suppressed = self._suppressed.pop(str(line["event"]), 0)
        return {**line, "suppressed": suppressed} if suppressed else line


class Writer:
    """Lines on their way out, by a thread of its own: a terminal that is held up holds up nobody else."""

    def __init__(self, stream: TextIO, rendered: Callable[[Line], str]) -> None:
        self._stream = stream
        self._rendered = rendered
        self._restraint = Restraint()
        self._lines: Queue[tuple[int, Line | None]] = Queue(WAITING)
        self._dropped = 0
        self._thread = threading.Thread(target=self._write, name="log", daemon=True)
        self._thread.start()

    def msg(self, line: Line) -> None:
        """Write a line, or drop it where too many wait."""
        try:
            self._lines.put_nowait((time.monotonic_ns(), line))
        except Full:
            self._dropped += 1

    debug = info = warning = error = msg

    def close(self) -> None:
        """Write what waits, for as long as somebody reads."""
        with contextlib.suppress(Full):
            self._lines.put_nowait((0, None))
            self._thread.join(FAREWELL_S)

    def _write(self) -> None:
        due = time.monotonic() + LATE_S
        while True:
            with contextlib.suppress(Empty):
                came_ns, line = self._lines.get(timeout=LATE_S)
                if line is None:
                    break
                self._put(self._restraint.take(line, came_ns))
            if time.monotonic() >= due:
                due = time.monotonic() + LATE_S
                self._put(self._restraint.late(time.monotonic_ns()))
        self._put(self._restraint.rest())

    def _put(self, lines: Iterable[Line]) -> None:
        for line in lines:
            if dropped := self._dropped:
                self._dropped -= dropped
                line["lines_dropped"] = dropped
            with contextlib.suppress(OSError, ValueError):  # nobody reads any more
                self._stream.write(f"{self._rendered(line)}\n")
                self._stream.flush()


@contextmanager
def logging(form: Form = Form.AUTO, **fields: object) -> Iterator[FilteringBoundLogger]:
    """A logger to standard output; `fields` stand in every line. For people on a terminal, else logfmt."""
    stamped, rendered = _written(form)
    writer = Writer(sys.stdout, rendered)
    try:
        yield structlog.wrap_logger(
            writer,
            wrapper_class=structlog.make_filtering_bound_logger(0),
            processors=[add_log_level, stamped, lambda _logger, _method, line: ((line,), {})],
        ).bind(**fields)
    finally:
        writer.close()


def _written(form: Form) -> tuple[TimeStamper, Callable[[Line], str]]:
    """What puts the time into a line, and what makes text of it."""
    is_terminal = sys.stdout.isatty()
    if form is Form.TEXT or (form is Form.AUTO and is_terminal):
        text = ConsoleRenderer(pad_event_to=0, colors=is_terminal)
        return TimeStamper("%H:%M:%S", utc=False), lambda line: text(None, "", _legible(line))
    stamped = TimeStamper("iso", utc=True, key="time")
    if form is Form.JSON:
        json = JSONRenderer(ensure_ascii=False)
        return stamped, lambda line: str(json(None, "", line))
    logfmt = LogfmtRenderer(key_order=["time", "level", "event"], bool_as_flag=False)
    return stamped, lambda line: printable(logfmt(None, "", line))


def _legible(line: Line) -> Line:
    """Others' words are in it, such as of a sample that could not be read: no terminal is to obey them."""
    return {key: printable(told) if isinstance(told, str) else told for key, told in line.items()}
