"""The view's loop: what comes over the bus goes to the screen, ten times a second."""

import time
from collections.abc import Callable
from contextlib import nullcontext

from vsensor.view.ears import Ears
from vsensor.view.place import Place
from vsensor.view.screen import Screen
from vsensor.view.stream import Stream
from vsensor.view.viewer import Viewer

PERIOD_S = 0.1
FILE_PERIOD_S = 1.0
"""Where nobody looks on, rarer and longer columns make a smaller file."""

SILENCE_S = 3.0
"""Status comes each second: after this, it does not come."""


class Live:
    """One view at work. `new_stream` makes an empty stream, for the start and whenever time falls back."""

    def __init__(self, ears: Ears, screen: Screen, new_stream: Callable[[], Stream]) -> None:
        self._ears = ears
        self._screen = screen
        self._new_stream = new_stream
        self._stream = new_stream()
        self._heard = self._told = time.monotonic()

    def turn(self) -> None:
        """Show what has come since the last turn."""
        for message in self._ears.drain():
            self._heard = time.monotonic()
            if self._stream.falls_back(message):
                self._screen.send(self._stream.batches())
                self._screen.begin()
                self._stream = self._new_stream()
            self._stream.take(message)
        self._tell_silence()
        self._screen.send(self._stream.batches())

    def _tell_silence(self) -> None:
        now = time.monotonic()
        if now - self._heard >= SILENCE_S and now - self._told >= 1.0:
            self._told = now
            self._stream.silent(now - self._heard, time.time_ns())


def show(live: Live, place: Place, stopped: Callable[[], bool], say: Callable[[str], None]) -> None:
    """Open the viewer and let the view run until `stopped` says so, or the window is closed.

    A viewer that dies otherwise is spoken of once, and is not our end: the data are still served.
    """
    with nullcontext() if place.kind == "file" else Viewer(place) as viewer:
        watched = viewer
        while not stopped():
            live.turn()
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
        live.turn()
