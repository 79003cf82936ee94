"""Signals: Ctrl-C and SIGTERM end a command cleanly, a loop between two turns; SIGHUP tells it something."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SIGNALLED = 128
"""The exit status of what a signal has ended is this and its number, as a shell counts."""


def end_cleanly_when_terminated() -> None:
    """From here on SIGTERM ends this process as Ctrl-C does: what is half written is cleared away first."""
    signal.signal(signal.SIGTERM, _end)


def _end(number: int, _frame: object) -> None:
    raise SystemExit(SIGNALLED + number)


@contextmanager
def until_signalled() -> Iterator[Callable[[], bool]]:
    """Within, SIGINT and SIGTERM end nothing by themselves; yields the question whether one came."""
    came: list[int] = []

    def note(number: int, _frame: object) -> None:
        came.append(number)

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def at_hangup(then: Callable[[], None]) -> Iterator[None]:
    """Within, SIGHUP ends nothing, and `then` is called in the main thread."""
    before = signal.signal(signal.SIGHUP, lambda _number, _frame: then())
    try:
        yield
    finally:
        signal.signal(signal.SIGHUP, before)
