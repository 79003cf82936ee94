"""The process that serves metrics and probes over HTTP, for as long as the daemon holds the other end.

Started by `exporter.Exporter` as `python -m vsensor.metrics.process FD HOST PORT`.
"""

import contextlib
import signal
import socket
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from socketserver import ThreadingMixIn
from typing import TYPE_CHECKING
from wsgiref.simple_server import WSGIRequestHandler, WSGIServer, make_server

from prometheus_client import CollectorRegistry, make_wsgi_app
from prometheus_client.core import Metric
from prometheus_client.registry import Collector

from vsensor.messages import Status
from vsensor.messages.states import RUNNING, STARTING
from vsensor.metrics.exporter import READY, WORD_BYTES
from vsensor.metrics.families import families

if TYPE_CHECKING:
    from wsgiref.types import StartResponse, WSGIEnvironment

SILENCE_S = 5.0
"""A status comes each second: a loop that has told none for so long does not turn."""
PATIENCE_S = 5.0
"""Who asks and does not read is left alone after that."""


class Newest(Collector):
    """The last status, and how long ago it came."""

    def __init__(self) -> None:
        self._status = Status()
        self._came = time.monotonic()

    def take(self, status: Status) -> None:
        """Hear a status."""
        self._status, self._came = status, time.monotonic()

    @property
    def alive(self) -> bool:
        """Whether the loop turns."""
        return time.monotonic() - self._came < SILENCE_S

    @property
    def state(self) -> str:
        """What the daemon does, in its own words."""
        return (self._status.state or STARTING) if self.alive else "the loop does not turn"

    def collect(self) -> Iterator[Metric]:
        """Every metric; none of a loop that does not turn: an old value is no value."""
        yield from families(self._status) if self.alive and self._status.rig else ()


class App:
    """`/metrics`; `/livez`: the loop turns; `/readyz`: the bit is told, and well."""

    def __init__(self, newest: Newest) -> None:
        registry = CollectorRegistry()
        registry.register(newest)
        self._metrics = make_wsgi_app(registry, disable_compression=True)
        self._newest = newest

    def __call__(self, environ: "WSGIEnvironment", start: "StartResponse") -> Iterable[bytes]:
        """Answer one request."""
        path = environ.get("PATH_INFO", "")
        if path == "/metrics":
            answer: Iterable[bytes] = self._metrics(environ, start)
            return answer
        state = self._newest.state
        probes = {"/livez": self._newest.alive, "/readyz": state == RUNNING}
        if path not in probes:
            return _say(start, "404 Not Found", "known here are /metrics, /livez, /readyz")
        return _say(start, "200 OK" if probes[path] else "503 Service Unavailable", state)


def _say(start: "StartResponse", status: str, text: str) -> list[bytes]:
    start(status, [("Content-Type", "text/plain; charset=utf-8")])
    return [f"{text}\n".encode()]


class _Handler(WSGIRequestHandler):
    timeout = PATIENCE_S

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 -- the library's name
        """A scrape every few seconds is not worth a line."""


class _Server(ThreadingMixIn, WSGIServer):
    daemon_threads = True


class _Server6(_Server):
    address_family = socket.AF_INET6


def main(descriptor: int, host: str, port: int) -> int:
    """Serve until the daemon ends; 1 where the address cannot be had."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    feed = socket.socket(fileno=descriptor)
    newest = Newest()
    kind = _Server6 if ":" in host else _Server
    try:
        server = make_server(host, port, App(newest), kind, _Handler)
    except OSError as error:
        feed.send(f"cannot listen: {error.strerror}: choose another [metrics] port or host".encode())
        return 1
    threading.Thread(target=server.serve_forever, daemon=True).start()
    feed.send(READY)
    with contextlib.suppress(ConnectionResetError):
        while packet := feed.recv(WORD_BYTES):
            newest.take(Status.FromString(packet))
    server.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), sys.argv[2], int(sys.argv[3])))
