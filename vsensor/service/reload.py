"""A configuration read again while the sensor runs: what may change without a new start, and what may not."""

import threading
from pathlib import Path
from typing import Any, NamedTuple

from vsensor.config import Rig, differences, effective_toml, load
from vsensor.errors import ConfigError, VsensorError
from vsensor.service.health import Health
from vsensor.service.realtime import achieve
from vsensor.service.recording import Recorder

SAFE = ("loop.realtime", "loop.priority", "loop.processors", "loop.stay_awake", "view")
"""Keys, or tables, that the estimates do not hang on, and that can be taken up between two ticks."""


class Outcome(NamedTuple):
    """What came of a new reading: the configuration from now on, and what was done, in words."""

    rig: Rig
    words: str
    refused: bool = False

    @classmethod
    def refusal(cls, rig: Rig, why: object) -> "Outcome":
        """Nothing was taken up."""
        return cls(rig, f"refused: {why}", refused=True)


def changes(before: Rig, after: Rig) -> dict[str, str]:
    """Each key that differs, with what it was and is."""
    return {
        key: f"{_shown(was)} → {_shown(is_now)}" for key, (was, is_now) in differences(before, after).items()
    }


def is_safe(key: str) -> bool:
    """Whether a key may change while the sensor runs."""
    return any(key == safe or key.startswith(f"{safe}.") for safe in SAFE)


class Reload:
    """Reads a file again in a thread of its own; the loop asks what came of it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._thread: threading.Thread | None = None
        self._came: list[Rig | ConfigError] = []

    def begin(self) -> None:
        """Read it, unless it is being read."""
        if self._thread is None:
            self._came.clear()
            self._thread = threading.Thread(target=self._read, name="reload", daemon=True)
            self._thread.start()

    def result(self, now: Rig) -> Outcome | None:
        """What comes of it; None while nothing has come.

        Nothing of a file is taken up where any of its changes needs a new start.
        """
        if self._thread is None or self._thread.is_alive():
            return None
        # What came is taken out first: a signal may come between any two lines, and begins anew from then on.
        read = self._came.pop() if self._came else ConfigError(f"{self._path}: cannot be read")
        self._thread = None
        if isinstance(read, ConfigError):
            return Outcome.refusal(now, read)
        changed = changes(now, read)
        if not changed:
            return Outcome(now, "nothing has changed")
        if unsafe := {key: change for key, change in changed.items() if not is_safe(key)}:
            told = "; ".join(f"{key} {change}" for key, change in unsafe.items())
            why = f"{told}: needs a new start, for estimates or connections hang on it"
            return Outcome.refusal(now, why)
        told = "; ".join(f"{key} {change}" for key, change in changed.items())
        return Outcome(read, f"taken up: {told}")

    def _read(self) -> None:
        try:
            self._came.append(load(self._path))
        except ConfigError as error:
            self._came.append(error)


def take_up(now: Rig, read: Outcome, health: Health, recorder: Recorder | None) -> Outcome:
    """Take up, between two ticks, what was read; what came of it in the end.

    Sessions that begin later tell it, and what real-time settings were achieved with it.
    """
    rig = read.rig
    if rig.loop != now.loop:
        try:
            health.realtime = achieve(rig.loop, health.realtime.others)
        except VsensorError as error:
            achieve(now.loop, health.realtime.others)
            return Outcome.refusal(now, error)
    if recorder is not None and rig is not now:
        recorder.describe(effective_toml(rig), health.realtime.as_metadata())
    return read


def _shown(value: Any) -> str:
    return "none" if value is None else str(value)
