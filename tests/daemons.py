"""The daemon as a process, and a place on its bus from which to feed and to hear it."""

import signal
import socket
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import cast

import zenoh

from tests.rigs import Surface
from vsensor.bus import SURFACE_CACHE, Feed, Outbox, open_session
from vsensor.config import Bus, Rig, effective_toml
from vsensor.messages import BIT_ESTIMATE, SENSOR_EVENT, SENSOR_STATUS, Estimate, Event, Message, Status

PATIENCE_S = 60.0
"""Only a test that fails waits so long."""
START_S = 300.0
"""A first start compiles the kernels, on a machine that may have much else to do."""


def wait_until(true: Callable[[], bool], what: str, patience_s: float = PATIENCE_S) -> None:
    """Look again and again until it is true; AssertionError where it does not become so."""
    deadline = time.monotonic() + patience_s
    while not true():
        assert time.monotonic() < deadline, f"waited in vain for: {what}"
        time.sleep(0.01)


def free_bus() -> Bus:
    """A bus on a port of this machine that nobody has."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return Bus(listen=(f"tcp/127.0.0.1:{probe.getsockname()[1]}",))


def open_files(pid: int) -> list[str]:
    """What a process has open."""
    found = []
    for descriptor in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(FileNotFoundError):  # closed since, such as our own of this folder
            found.append(str(descriptor.readlink()))
    return found


class Daemon:
    """`vsensor run` as a process, with a folder and a port of its own."""

    def __init__(self, rig: Rig, bus: Bus, folder: Path, *options: str) -> None:
        recording = rig.recording.model_copy(update={"folder": folder / "recordings"})
        state = rig.state.model_copy(update={"folder": folder / "state"})
        self.rig = rig.model_copy(update={"bus": bus, "recording": recording, "state": state})
        self.config = folder / "rig.toml"
        self.config.write_text(effective_toml(self.rig), encoding="utf-8")
        self._log = folder / "said.txt"
        with self._log.open("wb") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "vsensor.cli.main", "run", str(self.config), *options],
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    @property
    def said(self) -> str:
        """All that it has said so far."""
        return self._log.read_text(encoding="utf-8")

    @property
    def recorder(self) -> int:
        """The process of the recorder, its only child."""
        pid = self.process.pid
        (child,) = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()
        return int(child)

    @property
    def sessions(self) -> list[Path]:
        """The complete sessions it has left."""
        return sorted(self.rig.recording.folder.glob("*.mcap"))

    def await_saying(self, text: str) -> None:
        """Wait until it has said this."""
        wait_until(lambda: text in self.said or self.process.poll() is not None, text, START_S)
        assert text in self.said, self.said

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        """End it by a signal; returns its exit status."""
        self.process.send_signal(number)
        return self.process.wait(PATIENCE_S)


class Post:
    """A client on the daemon's bus: a rig that sends, and a listener that keeps all it hears."""

    def __init__(self, session: zenoh.Session, prefix: str) -> None:
        self.session = session
        self.prefix = prefix
        self._outbox = Outbox(session, prefix, reliable=True, cache=SURFACE_CACHE)
        self._feed = Feed(session, prefix)
        self._heard: dict[str, list[Message]] = defaultdict(list)

    def send(self, surface: Surface) -> None:
        """Publish samples as a rig does."""
        for topic, sample in surface:
            self._outbox.put(topic, sample)

    def heard(self, topic: str) -> list[Message]:
        """All that was heard on a topic so far."""
        for told, message in self._feed.drain():
            self._heard[told].append(message)
        return self._heard[topic]

    @property
    def estimates(self) -> list[Estimate]:
        """The estimates heard so far."""
        return cast("list[Estimate]", self.heard(BIT_ESTIMATE))

    @property
    def events(self) -> list[tuple[str, bool]]:
        """The events heard so far: which, and whether it began."""
        return [(event.name, event.begins) for event in cast("list[Event]", self.heard(SENSOR_EVENT))]

    def await_status(self, true: Callable[[Status], bool], what: str) -> Status:
        """Wait for a status that is as wanted, and return it."""
        found: list[Status] = []
        seen = len(self.heard(SENSOR_STATUS))

        def looked() -> bool:
            fresh = cast("list[Status]", self.heard(SENSOR_STATUS)[seen:])
            found.extend(status for status in fresh if true(status))
            return bool(found)

        wait_until(looked, what)
        return found[0]


@contextmanager
def daemon(rig: Rig, bus: Bus, folder: Path, *options: str) -> Iterator[Daemon]:
    """A daemon that listens, ended at the latest on leaving."""
    started = Daemon(rig, bus, folder, *options)
    try:
        started.await_saying("READY")
        yield started
    finally:
        if started.process.poll() is None:
            started.process.kill()
        started.process.wait(PATIENCE_S)


@contextmanager
def post(of: Daemon) -> Iterator[Post]:
    """A client on this daemon's bus."""
    with open_session(of.rig.bus, "client") as session:
        yield Post(session, of.rig.prefix)
