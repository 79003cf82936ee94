"""What the daemon says: an event and its fields, for a person at a terminal or for whoever collects logs."""

import contextlib
import sys
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Iterator, MutableMapping
from contextlib import contextmanager
from enum import StrEnum
from functools import partial
from queue import Full, Queue
from typing import Any, TextIO

import structlog
from structlog.dev import ConsoleRenderer
from structlog.processors import JSONRenderer, LogfmtRenderer, TimeStamper, add_log_level
from structlog.typing import FilteringBoundLogger

from vsensor.bus.allowance import Allowance
from vsensor.cli.printable import printable

Line = MutableMapping[str, Any]

PER_SECOND = 0.1
BURST = 5
"""Lines of one kind: five at once and then one in ten seconds, however often it happens."""

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
    """Drops lines of a kind that come too often, and says in the next one how many."""

    def __init__(self) -> None:
        self._allowances: defaultdict[str, Allowance] = defaultdict(partial(Allowance, PER_SECOND, BURST))
        self._suppressed: Counter[str] = Counter()

    def __call__(self, _logger: object, _method: str, line: Line) -> Line:
        """Let a line pass, or drop it."""
        kind = str(line["event"])
        if not self._allowances[kind].take(time.monotonic_ns()):
            self._suppressed[kind] += 1
            raise structlog.DropEvent
        if suppressed := self._suppressed.pop(kind, 0):
            line["suppressed"] = suppressed
        return line


class Writer:
    """Lines on their way out, by a thread of its own: a terminal that is held up holds up nobody else."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lines: Queue[str | None] = Queue(WAITING)
        self._dropped = 0
        self._thread = threading.Thread(target=self._write, name="log", daemon=True)
        self._thread.start()

    def msg(self, text: str) -> None:
        """Write a line, or drop it where too many wait."""
        try:
            self._lines.put_nowait(text)
        except Full:
            self._dropped += 1

    debug = info = warning = error = msg

    def close(self) -> None:
        """Write what waits, for as long as somebody reads."""
        with contextlib.suppress(Full):
            self._lines.put_nowait(None)
            self._thread.join(FAREWELL_S)

    def _write(self) -> None:
        while (text := self._lines.get()) is not None:
            with contextlib.suppress(OSError, ValueError):  # nobody reads any more
                self._stream.write(f"{text}\n")
                self._stream.flush()
            if dropped := self._dropped:
                self._dropped -= dropped
                self.msg(f"{dropped} lines were dropped: nobody read them")


@contextmanager
def logging(form: Form = Form.AUTO, **fields: object) -> Iterator[FilteringBoundLogger]:
    """A logger to standard output; `fields` stand in every line. For people on a terminal, else logfmt."""
    writer = Writer(sys.stdout)
    try:
        yield structlog.wrap_logger(
            writer,
            wrapper_class=structlog.make_filtering_bound_logger(0),
            processors=[add_log_level, Restraint(), *_rendered(form)],
        ).bind(**fields)
    finally:
        writer.close()


def _rendered(form: Form) -> list[Any]:
    is_terminal = sys.stdout.isatty()
    if form is Form.TEXT or (form is Form.AUTO and is_terminal):
        text = ConsoleRenderer(pad_event_to=0, colors=is_terminal)
        return [TimeStamper("%H:%M:%S", utc=False), _legible, text]
    stamped = TimeStamper("iso", utc=True, key="time")
    if form is Form.JSON:
        return [stamped, JSONRenderer(ensure_ascii=False)]
    logfmt = LogfmtRenderer(key_order=["time", "level", "event"], bool_as_flag=False)
    return [stamped, logfmt, lambda _logger, _method, told: printable(told)]


def _legible(_logger: object, _method: str, line: Line) -> Line:
    """Others' words are in it, such as of a sample that could not be read: no terminal is to obey them."""
    return {key: printable(told) if isinstance(told, str) else told for key, told in line.items()}
