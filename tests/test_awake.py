"""Processors kept from idle states, by a descriptor that the daemon alone has open, for as long."""

import errno
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.daemons import open_files
from tests.threads import in_a_thread
from vsensor.config import Loop
from vsensor.errors import ConfigError
from vsensor.service import awake, realtime
from vsensor.service.realtime import Achieved

ZERO = bytes(4)
ALL = os.sched_getaffinity(0)


def ask(**asked: object) -> Achieved:
    """What is achieved of it, asked anew: whatever was asked for before is given back first."""
    loop = Loop.model_validate({"rate": 50.0, **asked})
    return in_a_thread(lambda: realtime.achieve(loop, ALL))


@pytest.fixture(autouse=True)
def nothing_is_left() -> Iterator[None]:
    yield
    ask()


@pytest.fixture
def device(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file in the device's place, on a machine that has idle states."""
    standing_in = tmp_path / "cpu_dma_latency"
    standing_in.touch()
    driver = tmp_path / "current_driver"
    driver.write_text("intel_idle\n", encoding="ascii")
    monkeypatch.setattr(awake, "DEVICE", standing_in)
    monkeypatch.setattr(awake, "DRIVER", driver)
    return standing_in


def open_here() -> list[str]:
    return open_files(os.getpid())


def test_no_latency_is_asked_for_as_long_as_the_descriptor_is_open(device: Path) -> None:
    achieved = ask(realtime="prefer", stay_awake=True)
    assert achieved.kept_awake
    assert "processors kept awake" in achieved.words
    assert achieved.as_metadata()["kept_awake"] == "yes"
    assert device.read_bytes() == ZERO
    assert open_here().count(str(device)) == 1


def test_it_is_not_asked_for_unless_it_is_wanted(device: Path) -> None:
    achieved = ask(realtime="prefer")
    assert not achieved.kept_awake
    assert "awake" not in achieved.words
    assert achieved.as_metadata()["kept_awake"] == "no"
    assert device.read_bytes() == b""


def test_asked_again_it_is_one_request_and_off_lets_go(device: Path) -> None:
    for _ in range(2):
        assert ask(realtime="prefer", stay_awake=True).kept_awake
    assert open_here().count(str(device)) == 1
    assert not ask().kept_awake
    assert str(device) not in open_here()


def test_what_is_started_does_not_hold_it(device: Path) -> None:
    """A recorder outlives its daemon: the processors must not be kept awake for it."""
    ask(realtime="prefer", stay_awake=True)
    inherited = device.open()
    os.set_inheritable(inherited.fileno(), True)
    with inherited:
        started = subprocess.Popen(["sleep", "60"], close_fds=False)
    try:
        assert open_files(started.pid).count(str(device)) == 1
    finally:
        started.kill()
        started.wait()


def test_a_device_that_is_not_there_is_told_with_what_would_help(device: Path) -> None:
    device.unlink()
    achieved = ask(realtime="prefer", stay_awake=True)
    assert not achieved.kept_awake
    told = achieved.refused[-1]
    assert f"stay awake: {device}: No such file or directory" in told
    assert "PrivateDevices" in told
    assert not device.exists()


def test_a_device_that_may_not_be_written_is_told_with_what_would_help(
    device: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_asked: object) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    told = ask(realtime="prefer", stay_awake=True).refused[-1]
    assert "Permission denied" in told
    assert "udev" in told


def test_a_device_that_refuses_the_number_is_not_held_open(monkeypatch: pytest.MonkeyPatch) -> None:
    full = Path("/dev/full")
    monkeypatch.setattr(awake, "DEVICE", full)
    achieved = ask(realtime="prefer", stay_awake=True)
    assert not achieved.kept_awake
    assert "/dev/full: No space left" in achieved.refused[-1]
    assert str(full) not in open_here()


def test_a_request_that_no_driver_heeds_is_not_taken_for_granted(device: Path) -> None:
    awake.DRIVER.write_text("none\n", encoding="ascii")
    achieved = ask(realtime="prefer", stay_awake=True)
    assert not achieved.kept_awake
    assert "nobody here would heed it" in achieved.refused[-1]
    assert str(device) not in open_here()


def test_a_kernel_that_names_no_driver_is_taken_at_its_word(device: Path) -> None:
    awake.DRIVER.unlink()
    assert ask(realtime="prefer", stay_awake=True).kept_awake


def test_required_and_refused_is_a_configuration_that_cannot_be_used(device: Path) -> None:
    device.unlink()
    with pytest.raises(ConfigError, match=r'"require" is not granted:\n(.*\n)*  stay awake: '):
        ask(realtime="require", stay_awake=True)


def test_granted_while_something_else_is_refused_it_goes_with_the_rest(device: Path) -> None:
    """As at a reload: what was before is asked for again, and that had no such wish."""
    with pytest.raises(ConfigError, match="4095"):
        ask(realtime="require", stay_awake=True, processors=[4095])
    assert not ask(realtime="prefer").kept_awake
    assert str(device) not in open_here()


def test_without_real_time_it_cannot_be_meant() -> None:
    with pytest.raises(ValueError, match=r'stay_awake: only with realtime = "prefer"'):
        Loop(stay_awake=True)


def test_the_kernel_itself_takes_the_request() -> None:
    if not os.access(awake.DEVICE, os.W_OK):
        pytest.skip(f"{awake.DEVICE} may not be written here")
    achieved = ask(realtime="prefer", stay_awake=True)
    if not achieved.kept_awake:
        assert awake.DRIVER.read_text(encoding="ascii") == "none\n"
        pytest.skip("nobody here would heed it")
    with awake.DEVICE.open("rb", buffering=0) as least_asked_for:
        assert least_asked_for.read(4) == ZERO
