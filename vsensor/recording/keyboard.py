"""The listener's keys, as commands to the player."""

import os
import select
import sys
import termios
import tty
from types import TracebackType
from typing import Self

from vsensor.recording.player import Command

KEYS = {b" ": Command.PAUSE, b".": Command.STEP, b"q": Command.QUIT}


class Keyboard:
    """Hears single keys while it is open, where standard input is a terminal in our hands.

    In a pipe, or in the background (where touching the terminal would stop us), it hears nothing.
    """

    def __init__(self) -> None:
        self._descriptor = -1
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
        if not self.listening or not select.select([self._descriptor], [], [], 0)[0]:
            return None
        return KEYS.get(os.read(self._descriptor, 1))
