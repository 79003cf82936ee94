"""What a service manager is told, over a real socket: readiness, the watchdog, the end."""

import re
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.daemons import Daemon, wait_until
from tests.rigs import SHORT
from vsensor.cli.run import FINISH_S
from vsensor.config import Bus, Loop
from vsensor.errors import ConfigError
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


@pytest.fixture
def unit(tmp_path: Path) -> Path:
    """The template as it is shipped, but with a program that is there."""
    text = (UNITS / "vsensor@.service").read_text(encoding="utf-8")
    file = tmp_path / "vsensor@well-b.service"
    file.write_text(text.replace("/opt/vsensor/bin/vsensor", sys.executable), encoding="utf-8")
    return file


def analysed(*words: str) -> str:
    done = subprocess.run(["systemd-analyze", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="there is no systemd here")
def test_systemd_takes_the_unit_as_it_is_and_finds_it_well_shut(unit: Path) -> None:
    assert analysed("verify", "--man=no", str(unit)) == ""
    told = analysed("security", "--offline=yes", "--no-pager", str(unit))
    level = re.search(r"Overall exposure level for \S+: ([0-9.]+)", told)
    assert level
    assert float(level[1]) < 2


@pytest.mark.skipif(shutil.which("systemctl") is None, reason="there is no systemd here")
def test_enabled_without_a_name_it_is_for_the_one_rig(tmp_path: Path) -> None:
    folder = tmp_path / "etc/systemd/system"
    folder.mkdir(parents=True)
    shutil.copy(UNITS / "vsensor@.service", folder)
    subprocess.run(["systemctl", f"--root={tmp_path}", "enable", "vsensor@"], capture_output=True, check=True)
    assert [link.name for link in folder.glob("multi-user.target.wants/*")] == ["vsensor@rig.service"]


@pytest.fixture
def settings() -> dict[str, str]:
    """What the template says, by the key; the last of a key that is there twice."""
    text = (UNITS / "vsensor@.service").read_text(encoding="utf-8")
    return dict(line.split("=", 1) for line in text.splitlines() if re.match(r"[A-Z]\w+=", line))


def test_the_unit_waits_as_long_as_the_daemon_may_take(settings: dict[str, str]) -> None:
    """To be ready, between two words to the watchdog, and to complete its session."""
    assert settings["Type"] == "notify"
    assert int(settings["WatchdogSec"].removesuffix("s")) > 5
    assert int(settings["TimeoutStopSec"].removesuffix("s")) > FINISH_S


def test_a_recorder_whose_daemon_was_killed_is_left_to_complete_the_session(settings: dict[str, str]) -> None:
    """It ends by itself; in any other mode systemd kills it at once where the daemon crashed or hung."""
    assert settings["KillMode"] == "process"


def test_the_unit_grants_all_that_real_time_may_ask_for(settings: dict[str, str]) -> None:
    """By limits, since the process has no capability."""
    highest = int(settings["LimitRTPRIO"])
    assert Loop(realtime="prefer", priority=highest).priority == highest
    with pytest.raises(ValueError, match="priority"):
        Loop(realtime="prefer", priority=highest + 1)
    assert settings["LimitMEMLOCK"] == "infinity"
    assert "RestrictRealtime" not in settings


def test_a_configuration_that_is_refused_is_not_tried_again() -> None:
    """Which holds for the daemon's own exit status, not for what is run before it."""
    text = (UNITS / "vsensor@.service").read_text(encoding="utf-8")
    assert f"RestartPreventExitStatus={ConfigError.exit_status}\n" in text
    assert all(before.startswith("-") for before in re.findall(r"^ExecStartPre=(.*)$", text, re.MULTILINE))
