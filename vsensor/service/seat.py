"""Which of several sensors of one rig speaks: the one that took the seat first.

Another that hears of it stands by, where it was told to, or ends. One that stands by runs along on the same
samples and obeys the same commands, in silence, so that it can take the seat between two ticks.
"""

import time
from collections.abc import Callable

import zenoh

from vsensor.bus import Questions
from vsensor.commands import COMMAND
from vsensor.errors import BusError
from vsensor.messages import SENSOR_ALIVE, SENSOR_COMMAND, SENSOR_EVENT, SENSOR_STATUS, Event
from vsensor.messages.surface import PROTOBUF

CAPACITY = 256


class Seat:
    """The place of the one sensor that speaks; never waits but at the start.

    There it listens for `patience_s` whether the seat is taken: BusError where it is, and it was not told to
    stand by. Clocks of two machines differ, so the time of a claim alone would not do.
    """

    def __init__(self, session: zenoh.Session, prefix: str, *, stand_by: bool, patience_s: float) -> None:
        self.taken = False
        """Whether it is ours."""
        self._session = session
        self._prefix = prefix
        self._stands_by = stand_by
        # By the order in which the seat was taken; two that took it at once agree by their names.
        self._claim = f"{time.time_ns():020d}-{session.info.zid()}"
        self._claims: set[str] = set()
        self._tokens: list[zenoh.LivelinessToken] = []
        self._questions: Questions | None = None
        self._commands: Questions | None = None
        self._heard = session.liveliness().declare_subscriber(
            f"{prefix}/{SENSOR_ALIVE}/*", zenoh.handlers.RingChannel(CAPACITY), history=True
        )
        self._events = session.declare_subscriber(
            f"{prefix}/{SENSOR_EVENT}", zenoh.handlers.RingChannel(CAPACITY)
        )
        until = time.monotonic() + patience_s
        while not (others := self._others()) and time.monotonic() < until:
            time.sleep(0.02)
        if others and not stand_by:
            raise self._refused()
        if not stand_by:
            self._take()

    def look(self) -> str:
        """Take the seat or leave it, as the others' claims ask; returns what was done, "" for nothing.

        Raises BusError where it is another's, and this one was not told to stand by.
        """
        others = self._others()
        if self.taken and others and min(others) < self._claim:
            self._leave()
            if not self._stands_by:
                raise self._refused()
            return "another sensor speaks for this rig: standing by"
        if not self.taken and not others:
            self._claim = f"{time.time_ns():020d}-{self._session.info.zid()}"
            self._take()
            return "no other sensor speaks for this rig: taking its place"
        return ""

    def answer(self, status: Callable[[], bytes], obey: Callable[[str], str]) -> None:
        """Answer what was asked; while standing by obey, in silence, what the other was told."""
        if self._questions is not None and self._commands is not None:
            self._questions.answer(lambda _words: status(), encoding=PROTOBUF)
            self._commands.answer(obey)
        for words in self._overheard():
            try:
                obey(words)
            except ValueError:  # it was not for us: of the other's recording, or of another string
                continue

    def _others(self) -> set[str]:
        """Claims of other sensors, as far as heard."""
        while (heard := self._heard.try_recv()) is not None:
            claim = str(heard.key_expr).rpartition("/")[2]
            (self._claims.add if heard.kind == zenoh.SampleKind.PUT else self._claims.discard)(claim)
        return self._claims - {self._claim}

    def _refused(self) -> BusError:
        return BusError(
            f"another sensor speaks for {self._prefix}, since before: end it, or run this one "
            "with --stand-by, to take its place when it ends"
        )

    def _overheard(self) -> list[str]:
        words = []
        while (raw := self._events.try_recv()) is not None:
            if self.taken:
                continue
            try:
                event = Event.FromString(raw.payload.to_bytes())
            except Exception:  # noqa: S112 -- protobuf's own error type differs by backend
                continue
            if event.name == COMMAND:
                words.append(event.text)
        return words

    def _take(self) -> None:
        alive = f"{self._prefix}/{SENSOR_ALIVE}"
        declare = self._session.liveliness().declare_token
        self._tokens = [declare(f"{alive}/{self._claim}"), declare(alive)]
        self._questions = Questions(self._session, f"{self._prefix}/{SENSOR_STATUS}")
        self._commands = Questions(self._session, f"{self._prefix}/{SENSOR_COMMAND}")
        self.taken = True

    def _leave(self) -> None:
        for token in self._tokens:
            token.undeclare()  # type: ignore[no-untyped-call]
        self._tokens = []
        self._questions = self._commands = None
        self.taken = False
