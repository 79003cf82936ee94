"""The listener's keys, as commands to the player."""

import os
import re
import select
import sys
import termios
import tty
from collections import deque
from types import TracebackType
from typing import Self

from vsensor.recording.player import Command

KEYS = {
    b" ": Command.PAUSE,
    b".": Command.STEP,
    b"q": Command.QUIT,
    b"[D": Command.BACK,  # the arrows: left, right, down, up
    b"[C": Command.FORWARD,
    b"[B": Command.FAR_BACK,
    b"[A": Command.FAR_FORWARD,
}
HELP = "space pauses, . steps, ← → 10 s, ↓ ↑ a minute, q ends"
_KEY = re.compile(rb"\x1b[\[O]([A-Z])|(.)", re.DOTALL)
"""An arrow, as a terminal sends it in either of its modes, or a single character."""


class Keyboard:
    """Hears single keys while it is open, where standard input is a terminal in our hands.

    In a pipe, or in the background (where touching the terminal would stop us), it hears nothing.
    """

    def __init__(self) -> None:
        self._descriptor = -1
        self._pressed: deque[bytes] = deque()
        self._settings: list[int | list[bytes | int]] | None = None

    def __enter__(self) -> Self:
        if sys.stdin.isatty() and os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp():
            self._descriptor = sys.stdin.fileno()
            self._settings = termios.tcgetattr(self._descriptor)
            tty.setcbreak(self._descriptor)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._settings is not None:
            termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._settings)

    @property
    def listening(self) -> bool:
        """Whether there are keys to hear."""
        return self._settings is not None

    def command(self) -> Command | None:
        """What the next key that was pressed means; never waits."""
        if self.listening and select.select([self._descriptor], [], [], 0)[0]:
            for arrow, key in _KEY.findall(os.read(self._descriptor, 64)):
                self._pressed.append(b"[" + arrow if arrow else key)
        return KEYS.get(self._pressed.popleft()) if self._pressed else None
