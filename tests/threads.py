"""Work in a thread of its own."""

import threading
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


def in_a_thread(work: Callable[[], T]) -> T:
    """Run it in a thread of its own, whose scheduling ends with it."""
    came: list[T | BaseException] = []

    def run() -> None:
        try:
            came.append(work())
        except BaseException as error:  # carried to the test's own thread
            came.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    if isinstance(came[0], BaseException):
        raise came[0]
    return came[0]
