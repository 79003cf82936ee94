"""Ctrl-C and SIGTERM as a question that a loop asks itself, so that it ends between two turns."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager


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
