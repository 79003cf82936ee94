"""Questions put to a sensor, and how they are asked: to tell, or to do, something."""

from collections.abc import Callable

import zenoh

from vsensor.errors import BusError
from vsensor.messages import (
    SENSOR_COMMAND,
    SENSOR_STATUS,
    Status,
    surface,
)

QUESTIONS_CAPACITY = 16
"""Of more that come at once the oldest go unanswered."""
QUESTION_BYTES = 200
"""What a driller may say is far shorter."""
ANSWER_S = 5.0
"""A sensor that has not answered by then does not."""
UNANSWERED = "is the daemon (vsensor run) up? Behind a lock: is this client's role allowed to ask?"


class Questions:
    """Questions put to the sensor, to tell or to do something, drained without waiting.

    The loop answers them itself: another thread would hold the interpreter while the loop is due.
    """

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._queryable = session.declare_queryable(key, zenoh.handlers.RingChannel(QUESTIONS_CAPACITY))

    def answer(self, reply: Callable[[str], str | bytes], encoding: str = surface.TEXT) -> None:
        """Answer what has come since the last call: `reply` returns the answer, or raises ValueError."""
        for _ in range(QUESTIONS_CAPACITY):
            if (query := self._queryable.try_recv()) is None:
                return
            with query:
                words = b"" if query.payload is None else query.payload.to_bytes()[:QUESTION_BYTES]
                try:
                    query.reply(query.key_expr, reply(words.decode("utf-8", "replace")), encoding=encoding)
                except ValueError as error:
                    query.reply_err(str(error))


def command(session: zenoh.Session, prefix: str, words: str) -> str:
    """Tell a sensor something; returns what it did. Raises BusError where it refuses or does not answer."""
    for reply in session.get(f"{prefix}/{SENSOR_COMMAND}", payload=words, timeout=ANSWER_S):
        if reply.ok is not None:
            return reply.ok.payload.to_string()
        if reply.err is not None:
            raise BusError(reply.err.payload.to_string())
    raise BusError(f"no sensor answers at {prefix}/{SENSOR_COMMAND}: {UNANSWERED}")


def ask_status(session: zenoh.Session, prefix: str) -> Status:
    """A sensor's status of this second. Raises BusError where none answers."""
    for reply in session.get(f"{prefix}/{SENSOR_STATUS}", timeout=ANSWER_S):
        if reply.ok is not None:
            return Status.FromString(reply.ok.payload.to_bytes())
    raise BusError(f"no sensor answers at {prefix}/{SENSOR_STATUS}: {UNANSWERED}")
