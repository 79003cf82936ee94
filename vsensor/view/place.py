"""Where the view is shown: a window, a page for the browser, or only a file."""

import ipaddress
import os
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import quote

from vsensor.errors import VsensorError

LOOPBACK = "127.0.0.1"
DATA_PORT = 9876
PAGE_PORT = 9090


class ViewError(VsensorError):
    """The view cannot be shown or saved as asked; the message names the port, the address or the file."""


@dataclass(frozen=True, slots=True)
class Place:
    """What is opened, where the data are served (all but a file alone), and what is written."""

    kind: Literal["window", "page", "file"]
    data_port: int = DATA_PORT
    page_port: int = PAGE_PORT
    save: Path | None = None
    bind: str = LOOPBACK

    @property
    def host(self) -> str:
        """How this machine is reached by those who look: by name where it is bound to all its addresses."""
        address = ipaddress.ip_address(self.bind)
        if address.is_unspecified:
            return socket.gethostname()
        return f"[{self.bind}]" if address.version == 6 else self.bind

    @property
    def source(self) -> str:
        """The address that viewers draw from."""
        return f"rerun+http://{self.host}:{self.data_port}/proxy"

    @property
    def page(self) -> str:
        """The address of the page for a browser: dark as our colours want, without examples of Rerun's."""
        url = quote(self.source, safe="")
        return f"http://{self.host}:{self.page_port}/?url={url}&theme=dark&hide_welcome_screen"

    @property
    def origins(self) -> list[str]:
        """Pages besides this machine's own that may draw from the data's server."""
        return [] if self.bind == LOOPBACK else [f"http://{self.host}:{self.page_port}"]

    def words(self) -> str:
        """Where to look."""
        lines = {
            "window": ["the view opens in a window of its own; closing it ends the view"],
            "page": [f"open {self.page}"],
            "file": [],
        }[self.kind]
        opened = ["whoever reaches this machine can look on"] if self._is_open else []
        written = [f"written to {self.save}"] if self.save else []
        return "\n".join([*lines, *opened, *written])

    @property
    def _is_open(self) -> bool:
        return self.kind != "file" and not ipaddress.ip_address(self.bind).is_loopback

    def numbered(self, count: int) -> Path | None:
        """The file for the so-many-th recording."""
        if self.save is None or count == 1:
            return self.save
        return self.save.with_stem(f"{self.save.stem}-{count}")


@contextmanager
def choose(
    *,
    web: bool,
    save: Path | None,
    page_port: int | None,
    data_port: int | None,
    bind: str = LOOPBACK,
    say: Callable[[str], None],
) -> Iterator[Place]:
    """The place asked for; a page instead of a window where there is no display. Raises ViewError.

    Until the end of the `with` no other view takes its ports: they are served at only later, by Rerun.
    """
    if save and not web:
        yield Place("file", save=save)
        return
    _check(bind)
    with ExitStack() as held:
        data = _port("--data-port", data_port, DATA_PORT, bind, held)
        if not web and has_display():
            yield Place("window", data, bind=bind)
            return
        if not web:
            say("there is no display for a window here: the view is served for a browser instead")
        yield Place("page", data, _port("--port", page_port, PAGE_PORT, bind, held), save, bind)


def has_display() -> bool:
    """Whether a window can be opened."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _check(bind: str) -> None:
    try:
        with _probe(bind) as probe:
            probe.bind((bind, 0))
    except (ValueError, OSError) as error:
        raise ViewError(
            f"--bind {bind}: is no address of this machine: write one such as 10.1.2.3, or 0.0.0.0 for all "
            f"of them, or leave it out for this machine alone ({LOOPBACK})"
        ) from error


def _port(option: str, asked: int | None, usual: int, bind: str, held: ExitStack) -> int:
    """The port asked for, which must be free; else the usual one, or where that is taken any other."""
    port = asked or usual
    while not (reserved := _reserve(port, bind)):
        if asked:
            raise ViewError(f"{option} {asked}: is taken by another program: name another, or leave it out")
        port = _any_free(bind)
    held.enter_context(reserved)
    return port


def _reserve(port: int, bind: str) -> socket.socket | None:
    """What keeps a free port from other views: UDP's of the same number, which Rerun leaves alone.

    None where the port is taken.
    """
    with _probe(bind) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((bind, port))
        except OSError:
            return None
    held = _probe(bind, socket.SOCK_DGRAM)
    try:
        held.bind((bind, port))
    except OSError:
        held.close()
        return None
    return held


def _any_free(bind: str) -> int:
    with _probe(bind) as probe:
        probe.bind((bind, 0))
        return int(probe.getsockname()[1])


def _probe(bind: str, kind: socket.SocketKind = socket.SOCK_STREAM) -> socket.socket:
    family = socket.AF_INET6 if ipaddress.ip_address(bind).version == 6 else socket.AF_INET
    return socket.socket(family, kind)
