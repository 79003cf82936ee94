"""Where the view is shown: a window, a page for the browser, or only a file."""

import os
import socket
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import quote

from vsensor.errors import VsensorError

HOST = "127.0.0.1"
DATA_PORT = 9876
PAGE_PORT = 9090


class ViewError(VsensorError):
    """The view cannot be shown or saved as asked; the message names the port or the file."""


@dataclass(frozen=True, slots=True)
class Place:
    """What is opened, where the data are served (all but a file alone), and what is written."""

    kind: Literal["window", "page", "file"]
    data_port: int = DATA_PORT
    page_port: int = PAGE_PORT
    save: Path | None = None

    @property
    def source(self) -> str:
        """The address that viewers draw from."""
        return f"rerun+http://{HOST}:{self.data_port}/proxy"

    @property
    def page(self) -> str:
        """The address of the page for a browser."""
        return f"http://{HOST}:{self.page_port}/?url={quote(self.source, safe='')}"

    def words(self) -> str:
        """Where to look."""
        lines = {
            "window": ["the view opens in a window of its own; closing it ends the view"],
            "page": [f"open {self.page}"],
            "file": [],
        }[self.kind]
        written = [f"written to {self.save}"] if self.save else []
        return "\n".join([*lines, *written, "Ctrl-C ends it"])

    def numbered(self, count: int) -> Path | None:
        """The file for the so-many-th recording."""
        if self.save is None or count == 1:
            return self.save
        return self.save.with_stem(f"{self.save.stem}-{count}")


def choose(
    *, web: bool, save: Path | None, page_port: int | None, data_port: int | None, say: Callable[[str], None]
) -> Place:
    """The place asked for; a page instead of a window where there is no display. Raises ViewError."""
    if save and not web:
        return Place("file", save=save)
    data = _port("--data-port", data_port, DATA_PORT)
    if not web and has_display():
        return Place("window", data)
    if not web:
        say("there is no display for a window here: the view is served for a browser instead")
    return Place("page", data, _port("--port", page_port, PAGE_PORT), save)


def has_display() -> bool:
    """Whether a window can be opened."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _port(option: str, asked: int | None, usual: int) -> int:
    """The port asked for, which must be free; else the usual one, or where that is taken any other."""
    if asked is None:
        return usual if _is_free(usual) else _any_free()
    if not _is_free(asked):
        raise ViewError(f"{option} {asked}: is taken by another program: name another, or leave it out")
    return asked


def _is_free(port: int) -> bool:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError:
            return False
        return True


def _any_free() -> int:
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])
