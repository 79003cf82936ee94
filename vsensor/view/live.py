"""The view's loop: what comes over the bus goes to the screen, ten times a second."""

import time
from collections.abc import Callable, Iterable
from contextlib import nullcontext

from vsensor.grid import NS
from vsensor.messages import Message, Tick
from vsensor.view.ears import Ears
from vsensor.view.part import Every
from vsensor.view.place import Place
from vsensor.view.screen import Screen
from vsensor.view.stream import Stream
from vsensor.view.stuck import Stuck
from vsensor.view.viewer import Viewer

PERIOD_S = 0.1
FILE_PERIOD_S = 1.0
"""Where nobody looks on, rarer and longer columns make a smaller file."""

SILENCE_S = 3.0
"""Status comes each second: after this, it does not come."""


class Show:
    """A stream on a screen. `new_stream` makes an empty one, for the start and whenever time falls back."""

    def __init__(self, screen: Screen, new_stream: Callable[[], Stream]) -> None:
        self._screen = screen
        self._new_stream = new_stream
        self.stream = new_stream()

    def take(self, message: Message) -> None:
        """Take in one message."""
        if self.stream.falls_back(message):
            self.send()
            self._screen.begin()
            self.stream = self._new_stream()
        self.stream.take(message)

    def send(self) -> None:
        """Show what has come since the last call."""
        if self.stream.reach:
            self._screen.fit(self.stream.reach)
        self._screen.send(self.stream.batches())

    def fill(self, messages: Iterable[Message]) -> None:
        """Show a whole session, second by second of its own time."""
        second = Every(NS)
        for message in messages:
            self.take(message)
            if isinstance(message, Tick) and second.due(message.time_ns):
                self.send()
        self.send()


class Live:
    """One view at work."""

    def __init__(self, ears: Ears, show: Show) -> None:
        self._ears = ears
        self._show = show
        self._heard = self._told = time.monotonic()

    def turn(self) -> None:
        """Show what has come since the last turn."""
        waited = 0
        for message in self._ears.drain():
            self._heard = time.monotonic()
            self._show.take(message)
            waited += 1
        self._show.stream.waited(waited)
        self._tell_silence()
        self._show.send()

    def _tell_silence(self) -> None:
        now = time.monotonic()
        if now - self._heard >= SILENCE_S and now - self._told >= 1.0:
            self._told = now
            self._show.stream.silent(now - self._heard, time.time_ns())


def run(
    turn: Callable[[], None], place: Place, stopped: Callable[[], bool], say: Callable[[str], None]
) -> None:
    """Open the viewer and `turn` until `stopped` says so, or the window is closed.

    A viewer that dies otherwise is spoken of once, and is not our end: the data are still served.
    """
    stuck = Stuck(place.data_port)
    with nullcontext() if place.kind == "file" else Viewer(place) as viewer:
        watched = viewer
        while not stopped():
            turn()
            if stuck.let_go(time.monotonic()):
                say("a viewer that took nothing any more was let go; it can be opened again")
            status = watched.ended() if watched else None
            if status == 0:
                say("the window was closed")
                return
            if status is not None:
                watched = None
                say(
                    f"the viewer ended with status {status}. The view goes on: start another with "
                    f"rerun --connect {place.source}, or begin again with --web"
                )
            time.sleep(PERIOD_S if viewer else FILE_PERIOD_S)
        turn()
