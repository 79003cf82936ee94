"""Processes of the view: ports for them, waiting for them, and whether they have ended."""

import http.client
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

PATIENCE_S = 100.0
"""Only a test that fails waits so long: a view takes 5 s alone, and many times that beside others."""


def free_port() -> int:
    """A port of this machine that nobody has."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def until(question: Callable[[], bool]) -> None:
    """Ask again and again until it is so; AssertionError where it does not become so."""
    end = time.monotonic() + PATIENCE_S
    while not question():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def gone(pid: int) -> bool:
    """Whether a process has ended; one that nobody has waited for yet has."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


def children(pid: int) -> list[int]:
    """The processes that a process's main thread has started."""
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def offspring(pid: int) -> list[int]:
    """Those, and theirs."""
    return [each for child in children(pid) for each in (child, *offspring(child))]


def page(url: str) -> str:
    """What a server of ours answers."""
    with urllib.request.urlopen(url, timeout=PATIENCE_S) as answer:  # noqa: S310 -- our own page
        return str(answer.read(), "utf-8")


def reachable(url: str) -> bool:
    """Whether it answers."""
    try:
        page(url)
    except (OSError, http.client.HTTPException):  # the other where it dies within the answer
        return False
    return True


NOWHERE = {"DISPLAY": "", "WAYLAND_DISPLAY": ""}
"""The environment of a machine without a screen."""


@contextmanager
def at_work(
    *command: str, cwd: Path, environment: Mapping[str, str] = NOWHERE
) -> Iterator[Callable[[str], str]]:
    """A command of ours; yields what waits until it has said some words, and tells all that it has said.

    At the end it must end when told to, and all its processes with it.
    """
    process = subprocess.Popen(
        [sys.executable, "-m", "vsensor.cli.main", *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=cwd,
        env=os.environ | environment,
    )
    said: list[str] = []
    assert process.stdout is not None
    listener = threading.Thread(target=said.extend, args=(process.stdout,))
    listener.start()

    def await_words(words: str) -> str:
        until(lambda: words in "".join(said) or process.poll() is not None)
        assert words in "".join(said), "".join(said)
        return "".join(said)

    try:
        yield await_words
        children = offspring(process.pid)
        process.send_signal(signal.SIGTERM)
        assert process.wait(30) == 0, "".join(said)
        assert all(gone(child) for child in children)
    finally:
        process.kill()
        process.wait()
        listener.join()
        process.stdout.close()
