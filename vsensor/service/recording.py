"""What the loop does for the recorder: tells it what the sensor remembers, and what the driller wants."""

import time
from collections.abc import Mapping, Sequence
from typing import Protocol

from vsensor.checkpoint import remembered
from vsensor.commands import SNAPSHOT, about_recording
from vsensor.config import Rig
from vsensor.messages import State
from vsensor.service.engine import Engine
from vsensor.service.health import Recorded

KEEP_S = 60.0
"""A snapshot begins with what the sensor remembered at most so long before."""


Note = tuple[str, bool, str]
"""Something that the recorder did: an event's name, whether it begins, and in words."""


class Recorder(Recorded, Protocol):
    """Where everything is written; never makes the loop wait."""

    wants: bool
    unsent: int

    def offer(self, topic: str, data: bytes, log_time_ns: int, publish_time_ns: int) -> None:
        """Take a message along with the present slot's."""

    def send(self) -> None:
        """Hand the slot's messages on, or count what cannot be taken."""

    def look(self) -> Sequence[Note]:
        """Hear its news, and return what has happened since."""

    def describe(self, configuration: str, metadata: Mapping[str, str]) -> None:
        """Have files that begin from now on say this of themselves."""

    def next_path(self, kind: str = "") -> str:
        """A name for a file that begins now."""

    def checkpoint(self, order: str, path: str, state: State, arrays: Sequence[memoryview]) -> bool:
        """Hand over what the sensor remembers, with an order; whether it was taken."""

    def order(self, order: str, path: str = "", seconds: float = 0.0) -> bool:
        """Give an order that needs no state; whether it was taken."""


class Recording:
    """One daemon's recording. Between two turns of the loop only: then what is remembered is whole."""

    def __init__(self, rig: Rig, engine: Engine, recorder: Recorder) -> None:
        self._engine = engine
        self._recorder = recorder
        self._memory_s = rig.recording.memory
        self._between_s = max(1.0, min(KEEP_S, self._memory_s / 5)) if self._memory_s else None
        self._next_s = time.monotonic()
        self._unsent = 0

    def each_second(self) -> Sequence[Note]:
        """Hear the recorder, and tell it what the sensor remembers, where it wants that or may need it."""
        notes = self._recorder.look()
        lost, self._unsent = self._recorder.unsent > self._unsent, self._recorder.unsent
        if self._recorder.wants or lost or time.monotonic() >= self._next_s:
            self.remember()
        return notes

    def remember(self) -> None:
        """Tell the recorder what the sensor remembers; where it cannot be told now, it is tried again."""
        if self._checkpoint("keep", ""):
            self._next_s = time.monotonic() + (self._between_s or float("inf"))

    def obey(self, words: str) -> str | None:
        """Do what the driller says of the recording; returns what was done, None for other words.

        Raises ValueError where that cannot be.
        """
        told = about_recording(words)
        if told is None:
            return None
        verb, seconds = told
        recorder = self._recorder
        self._check(verb)
        path = recorder.next_path("-snapshot" if verb == SNAPSHOT else "") if verb != "stop" else ""
        given = (
            self._checkpoint(verb, path)
            if verb in ("start", "split")
            else recorder.order(verb, path, seconds)
        )
        if not given:
            raise ValueError("the recorder cannot take the order now: say it again")
        done = {
            "start": f"is to record into {path}: `vsensor status` says whether it does",
            "stop": f"{recorder.path} ends here",
            "split": f"{recorder.path} ends here, {path} goes on",
            SNAPSHOT: f"the last {_minutes(min(seconds, self._held_s()))} are being written to {path}",
        }[verb]
        recorder.path = {"start": path, "stop": "", "split": path}.get(verb, recorder.path)
        return done

    def _held_s(self) -> float:
        """How far back the recorder's memory reaches, as far as it has told: not to before the start."""
        reaches = round(self._recorder.figures.get("recording_memory_s", 0.0))
        return min(reaches or self._memory_s, self._memory_s)

    def _check(self, verb: str) -> None:
        recorder = self._recorder
        if trouble := recorder.trouble():
            raise ValueError(trouble)
        if verb == "start" and recorder.path:
            raise ValueError(f"is recording already, into {recorder.path}")
        if verb in ("stop", "split") and not recorder.path:
            raise ValueError("is not recording")
        if verb == SNAPSHOT and not self._memory_s:
            raise ValueError("nothing is held in memory: set [recording] memory")

    def _checkpoint(self, order: str, path: str) -> bool:
        state, arrays = remembered(self._engine.intake, self._engine.estimator)
        return self._recorder.checkpoint(order, path, state, [array.data for array in arrays])


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:g} min" if seconds >= 60 else f"{seconds:g} s"
