"""A player's surroundings: a clock that never waits, listener, keys and terminal, and a session."""

import os
import pty
import re
import threading
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, cast

from vsensor.messages import BIT_SPEED, SURFACE_TORQUE, Message, Sample
from vsensor.recording.course import Course
from vsensor.recording.player import Command, play
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

MS = 1_000_000
SECOND = 1000 * MS


class FakeClock:
    """Time passes only by sleeping (and oversleeping), and by work between."""

    def __init__(self, overshoot_ns: int = 0) -> None:
        self.time_ns = 777 * SECOND
        self.overshoot_ns = overshoot_ns

    def now_ns(self) -> int:
        return self.time_ns

    def sleep_until(self, time_ns: int) -> None:
        self.time_ns = max(self.time_ns, time_ns + self.overshoot_ns)


class Listener:
    """Notes what came, and when after the first."""

    def __init__(self, clock: FakeClock, work_ns: int = 0) -> None:
        self._clock = clock
        self._work_ns = work_ns
        self.topics: list[str] = []
        self.samples: list[Sample] = []
        self.times_ns: list[int] = []

    def put(self, topic: str, message: Message) -> None:
        sample = cast("Sample", message)
        self.topics.append(topic)
        self.samples.append(sample)
        self.times_ns.append(self._clock.time_ns)
        self._clock.time_ns += self._work_ns

    @property
    def after_ns(self) -> list[int]:
        return [time_ns - self.times_ns[0] for time_ns in self.times_ns]

    def stamps_ms(self) -> list[float]:
        return [sample.time_ns / MS for sample in self.samples]


def session_of(
    path: Path,
    times_ms: Iterable[float],
    arrivals_ms: Iterable[float] | None = None,
    sync_each: int = 1 << 30,
) -> Session:
    start_ns = 5 * SECOND
    times = [start_ns + round(time * MS) for time in times_ms]
    arrivals = times if arrivals_ms is None else [start_ns + round(time * MS) for time in arrivals_ms]
    with SessionWriter(path, configuration="", metadata={"rig": "r"}, compression="none") as writer:
        for number, (time_ns, arrival_ns) in enumerate(zip(times, arrivals, strict=True)):
            sample = Sample(time_ns=time_ns, value=number, sequence=100 + number)
            writer.write(SURFACE_TORQUE, sample.SerializeToString(), arrival_ns, time_ns)
            writer.write(BIT_SPEED, sample.SerializeToString(), arrival_ns, time_ns)
            if number % sync_each == 0:
                writer.sync()
    return Session(path)


def after(clock: FakeClock, script: dict[int, Command]) -> Callable[[], Command | None]:
    """A listener at the keyboard who gives each command once, that many ns after the start."""
    start_ns = clock.time_ns
    waiting = sorted(script.items())

    def command() -> Command | None:
        if waiting and clock.time_ns - start_ns >= waiting[0][0]:
            return waiting.pop(0)[1]
        return None

    return command


def played(session: Session, script: dict[int, Command], clock: FakeClock, **given: Any) -> Listener:
    """What comes of a session while somebody gives these commands, so many ns after its start."""
    listener = Listener(clock)
    play(Course([session]), listener.put, clock=clock, command=after(clock, script), **given)
    return listener


class Terminal:
    """A terminal of a player's own: what is typed there, and the line that it shows last."""

    def __init__(self) -> None:
        self._ours, self.theirs = pty.openpty()
        self._shown = ""
        threading.Thread(target=self._read, daemon=True).start()

    def type(self, keys: bytes) -> None:
        os.write(self._ours, keys)

    def line(self) -> str:
        """The last that is not empty, without what moves the cursor and colours."""
        lines = re.split(r"[\r\n]+", re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", self._shown))
        return next((line.strip() for line in reversed(lines) if line.strip()), "")

    def close(self) -> None:
        os.close(self.theirs)

    def _read(self) -> None:
        # The last end that the player's side is closed by ends it.
        while True:
            try:
                some = os.read(self._ours, 1 << 16)
            except OSError:
                break
            self._shown = (self._shown + some.decode(errors="replace"))[-(1 << 16) :]
        os.close(self._ours)
