"""While a lot of messages is written to a slow disk, the recorder tells how things stand."""

import socket
from types import SimpleNamespace
from typing import Any

import pytest

from vsensor.recording import process
from vsensor.recording.backlog import Backlog
from vsensor.recording.process import Reporter


class SlowClerk:
    """Writes, and has news; each packet takes it some seconds."""

    failed = has_more = False

    def __init__(self, write_s: float) -> None:
        self.happened: list[str] = []
        self.now = 100.0
        self._write_s = write_s

    def take(self, _item: bytes) -> None:
        self.now += self._write_s
        self.happened.append("written")

    def work(self) -> None:
        """No snapshot is under way."""

    def news(self) -> dict[str, Any]:
        self.happened.append("told")
        return {"trouble": ""}


@pytest.mark.parametrize(
    ("write_s", "happened"),
    [(3.0, ["written", "told"] * 4), (0.6, ["written", "told", "written", "written", "told", "written"])],
)
def test_it_tells_each_second_between_two_packets(
    write_s: float, happened: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clerk: Any = SlowClerk(write_s)
    monkeypatch.setattr(process, "time", SimpleNamespace(monotonic=lambda: clerk.now))
    backlog = Backlog(1000)
    for _ in range(4):
        backlog.put(b"packet")
    backlog.ended.set()
    ours, feed = socket.socketpair()
    with ours, feed:
        process._record(backlog, clerk, Reporter(clerk, feed))
    assert clerk.happened == happened
