"""What a service manager is told, over a real socket: readiness, the watchdog, the end."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.daemons import Daemon, wait_until
from tests.rigs import SHORT
from vsensor.config import Bus
from vsensor.messages import ChannelStatus, Status
from vsensor.service.systemd import Supervisor

UNITS = Path(__file__).parent.parent / "config" / "systemd"


@pytest.fixture
def manager(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "notify"))
        listening.setblocking(False)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        yield listening


def told(manager: socket.socket) -> list[str]:
    words = []
    while True:
        try:
            words.append(manager.recv(4096).decode())
        except BlockingIOError:
            return words


def second(ticks: int, accepted: int) -> Status:
    channels = [ChannelStatus(channel=name, accepted=accepted) for name in ("a", "b")]
    return Status(state="running", ticks=ticks, channels=channels)


def test_the_watchdog_is_fed_while_ticks_advance(manager: socket.socket) -> None:
    supervisor = Supervisor()
    for number in range(1, 4):
        supervisor.each_second(second(100 * number, 100 * number))
    assert told(manager) == ["STATUS=running\nWATCHDOG=1"] * 3


def test_it_starves_while_both_channels_speak_and_no_tick_comes(manager: socket.socket) -> None:
    supervisor = Supervisor()
    for number in range(1, 4):
        supervisor.each_second(second(100, 100 * number))
    assert told(manager) == ["STATUS=running\nWATCHDOG=1", "STATUS=running", "STATUS=running"]


def test_a_silent_rig_is_no_fault_of_the_daemon(manager: socket.socket) -> None:
    supervisor = Supervisor()
    for status in (second(0, 0), second(0, 0), second(100, 100), second(100, 100)):
        supervisor.each_second(status)
    assert all("WATCHDOG=1" in words for words in told(manager))


def test_without_a_manager_and_with_one_that_is_gone_nothing_happens(
    manager: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    manager.close()
    Supervisor().ready()
    monkeypatch.delenv("NOTIFY_SOCKET")
    Supervisor().ready()


@pytest.mark.process
def test_the_daemon_tells_when_it_is_ready_alive_and_stopping(
    manager: socket.socket, tmp_path: Path, bus: Bus
) -> None:
    heard: list[str] = []

    def hears(word: str) -> bool:
        heard.extend(told(manager))
        return any(word in words.split("\n") for words in heard)

    sensor = Daemon(SHORT, bus, tmp_path)
    try:
        sensor.await_saying("event=READY")
        wait_until(lambda: hears("WATCHDOG=1"), "a fed watchdog")
        assert heard[0] == "READY=1"
        assert "STATUS=waiting for samples\nWATCHDOG=1" in heard
        assert sensor.end() == 0
        assert hears("STOPPING=1")
    finally:
        if sensor.process.poll() is None:
            sensor.process.kill()
            sensor.process.wait()
