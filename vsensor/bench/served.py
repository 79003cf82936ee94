"""The live view at work: its server, its page, and one who looks on."""

import os
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from vsensor import demo
from vsensor.bench.processes import child_of
from vsensor.errors import VsensorError
from vsensor.view.place import Place
from vsensor.view.viewer import ENVIRONMENT, program

PATIENCE_S = 60.0


class Growth(NamedTuple):
    """When the file was seen to have grown, and to how many bytes; monotonic clock."""

    at_ns: int
    size: int


class Onlooker:
    """A client of the view's server: to be looked at again and again."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.growths: list[Growth] = []

    def look(self) -> None:
        """Note what has come since the last time."""
        try:
            size = self.file.stat().st_size
        except FileNotFoundError:
            return
        if not self.growths or size > self.growths[-1].size:
            self.growths.append(Growth(time.monotonic_ns(), size))


class View(NamedTuple):
    """A view at work, and one who looks on."""

    pids: tuple[int, int]
    """Of the view, and of its page's server."""
    looks: Onlooker


@contextmanager
def served(config: Path, file: Path) -> Iterator[View]:
    """The view as a page, as with no screen on the sensor's machine; the onlooker writes `file`.

    Raises VsensorError where the view does not serve.
    """
    place = Place("page", _free_port(), _free_port())
    ports = ("--data-port", str(place.data_port), "--port", str(place.page_port))
    with demo.process("view", str(config), "--web", *ports) as view:
        end = time.monotonic() + PATIENCE_S
        for port in (place.data_port, place.page_port):
            while not _answers(port):
                if view.poll() is not None or time.monotonic() > end:
                    raise VsensorError(f"vsensor view does not serve; it ended with status {view.poll()}")
                time.sleep(0.05)
        with _onlooker(place.source, file) as looks:
            yield View((view.pid, child_of(view.pid)), looks)


@contextmanager
def _onlooker(source: str, file: Path) -> Iterator[Onlooker]:
    """A client of the server at `source`, Rerun's own, that writes what it hears."""
    with subprocess.Popen(
        [program(), source, "--save", str(file)],
        env=os.environ | ENVIRONMENT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        start_new_session=True,
    ) as client:
        try:
            yield Onlooker(file)
        finally:
            client.kill()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0
