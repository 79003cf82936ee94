"""While a lot of messages is written to a slow disk, the recorder tells how things stand."""

import socket
import threading
from types import SimpleNamespace
from typing import Any

import pytest

from vsensor.recording import process
from vsensor.recording.backlog import Backlog
from vsensor.recording.process import Reporter


class SlowClerk:
    """Writes, and has news; each packet takes it some seconds."""

    failed = has_more = False

    def __init__(self, write_s: float, trouble: str = "") -> None:
        self.happened: list[str] = []
        self.trouble = trouble
        self.now = 100.0
        self._write_s = write_s

    def take(self, _item: bytes) -> None:
        self.now += self._write_s
        self.happened.append("written")

    def work(self) -> None:
        """No snapshot is under way."""

    def news(self) -> dict[str, Any]:
        self.happened.append("told")
        return {"trouble": self.trouble}

    def note(self, name: str, _begins: bool, _text: str) -> None:
        self.happened.append(name)


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


@pytest.mark.parametrize("somebody_hears", [True, False])
def test_what_is_wrong_is_said_on_the_terminal_only_where_no_daemon_can_tell_it(
    somebody_hears: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    clerk: Any = SlowClerk(0.0, "the disk is full")
    ours, feed = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with ours, feed:
        if not somebody_hears:
            ours.close()
        reporter = Reporter(clerk, feed)
        for _ in range(3):
            reporter.tell()
    said = "" if somebody_hears else "vsensor recorder: the disk is full\n"
    assert capfd.readouterr().err == said


def test_a_disk_that_does_not_keep_up_is_told_once(capfd: pytest.CaptureFixture[str]) -> None:
    clerk: Any = SlowClerk(0.0)
    backlog = Backlog(10)
    ours, feed = socket.socketpair()
    with ours, feed:
        backlog.dropped = 3
        ends = threading.Timer(0.3, backlog.ended.set)  # after some turns
        ends.start()
        process._record(backlog, clerk, Reporter(clerk, feed))
        ends.join()
    assert clerk.happened == ["backlog_full"]
    assert capfd.readouterr().err == ""
