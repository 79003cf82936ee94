"""Real-time settings: what is granted is told, what is not too, and only the loop's thread has them."""

import errno
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.daemons import daemon, open_files, post
from tests.rigs import SHORT
from tests.threads import in_a_thread
from vsensor.config import Bus, Loop, Rig
from vsensor.errors import ConfigError
from vsensor.messages import Status
from vsensor.recording.reader import Session
from vsensor.service import realtime
from vsensor.service.awake import DEVICE

ALL = os.sched_getaffinity(0)
LAST = max(ALL)
MODULES = 10_000
"""So many objects our modules alone are."""


def wanting(**asked: object) -> Loop:
    return Loop.model_validate({"rate": 50.0, **asked})


def refuse(*_asked: object) -> None:
    raise PermissionError(errno.EPERM, "Operation not permitted")


@pytest.fixture
def limits(monkeypatch: pytest.MonkeyPatch) -> dict[int, int]:
    """What a machine that refuses all the same allows by limits, without any capability."""
    allowed = {resource.RLIMIT_RTPRIO: 0, resource.RLIMIT_MEMLOCK: 8 << 20}
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(resource, "getrlimit", lambda which: (allowed[which], allowed[which]))
    monkeypatch.setattr(realtime, "_is_capable", lambda _capability: False)
    return allowed


def test_off_asks_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("sched_setscheduler", "sched_setaffinity"):
        monkeypatch.setattr(os, name, refuse)
    achieved = realtime.achieve(wanting())
    assert (achieved.asked, achieved.memory_locked, achieved.refused) == ("off", False, ())
    assert set(achieved.processors) == ALL


@pytest.mark.usefixtures("limits")
def test_what_is_not_granted_is_told_with_what_would_help() -> None:
    achieved = in_a_thread(
        lambda: realtime.achieve(wanting(realtime="prefer", priority=55, processors=[4095]))
    )
    assert (achieved.scheduling, achieved.memory_locked) == ("SCHED_OTHER", False)
    priority, memory, processors = achieved.refused
    assert "SCHED_FIFO 55" in priority
    assert "the limit is 0: " in priority
    assert "LimitRTPRIO" in priority
    assert "8192 KiB" in memory
    assert "LimitMEMLOCK" in memory
    assert "[4095]" in processors


@pytest.mark.usefixtures("limits")
def test_what_is_required_and_not_granted_is_a_configuration_that_cannot_be_used() -> None:
    """With its exit status a service manager does not try again what no trying mends."""
    with pytest.raises(ConfigError, match=r'"require" is not granted:\n  SCHED_FIFO 40: .*\n  memory lock'):
        in_a_thread(lambda: realtime.achieve(wanting(realtime="require")))


@pytest.mark.parametrize("limit", [40, resource.RLIM_INFINITY])
def test_a_priority_refused_in_spite_of_the_limit_is_not_put_down_to_the_limit(
    limits: dict[int, int], limit: int
) -> None:
    limits[resource.RLIMIT_RTPRIO] = limit
    priority = in_a_thread(lambda: realtime.achieve(wanting(realtime="prefer"))).refused[0]
    assert "LimitRTPRIO" not in priority
    assert "CONFIG_RT_GROUP_SCHED" in priority
    assert "RestrictRealtime" in priority


def test_processors_of_which_one_is_missing_are_not_all_that_was_required() -> None:
    with pytest.raises(ConfigError, match=r"processors \[\d+, 4095\]"):
        in_a_thread(lambda: realtime.achieve(wanting(realtime="require", processors=[LAST, 4095])))


def test_processors_are_pinned_for_the_thread_alone() -> None:
    achieved = in_a_thread(lambda: realtime.achieve(wanting(realtime="prefer", processors=[LAST])))
    assert achieved.processors == (LAST,)
    assert set(achieved.others) == ALL
    assert os.sched_getaffinity(0) == ALL


@pytest.mark.parametrize(
    ("asked", "fault"),
    [
        ({"processors": [0]}, "realtime"),
        ({"realtime": "yes"}, "off"),
        ({"realtime": "prefer", "priority": 99}, "98"),
        ({"realtime": "prefer", "processors": [-1]}, "0"),
    ],
)
def test_what_cannot_be_meant_is_refused(asked: dict[str, object], fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        wanting(**asked)


PREFERRING = """
from vsensor.config import Loop
from vsensor.service import realtime

print(*realtime.achieve(Loop(rate=50.0, realtime="prefer")).refused, sep="\\n")
"""


def refused_to(*around: str | Path) -> str:
    """What is told of a refusal by a process that these words start."""
    done = subprocess.run(
        [*around, sys.executable, "-c", PREFERRING], capture_output=True, text=True, check=True, timeout=60
    )
    return done.stdout


def test_capabilities_of_a_user_namespace_are_not_taken_for_leave() -> None:
    """As in a container without privileges: they are all there, and what counts is the limits."""
    within = ["unshare", "--user", "--map-root-user", "--"]
    if shutil.which(within[0]) is None or subprocess.run([*within, "true"], check=False).returncode:
        pytest.skip("no user namespace may be made here")
    if resource.getrlimit(resource.RLIMIT_RTPRIO)[0] or resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] < 0:
        pytest.skip("needs limits that refuse")
    priority, memory = refused_to(*within).splitlines()
    assert "LimitRTPRIO" in priority
    assert "LimitMEMLOCK" in memory


@pytest.fixture
def group() -> Iterator[Path]:
    """A control group that has no real-time run time yet, as a service manager would make it."""
    made = Path(f"/sys/fs/cgroup/cpu/vsensor-test-{os.getpid()}")
    if os.geteuid() != 0 or not (made.parent / "cpu.rt_runtime_us").exists():
        pytest.skip("needs a kernel that schedules real time by groups, and the right to make one")
    made.mkdir()
    yield made
    made.rmdir()


def test_a_group_without_real_time_is_told_as_what_refuses(group: Path) -> None:
    assert (group / "cpu.rt_runtime_us").read_text(encoding="ascii") == "0\n"
    enter = 'echo $$ > "$0" && exec "$@"'
    assert "CONFIG_RT_GROUP_SCHED" in refused_to("sh", "-c", enter, group / "cgroup.procs")


WITHOUT_LEAVE = """
import os, sys
from vsensor.config import Loop
from vsensor.service import realtime

ask = lambda **asked: realtime.achieve(Loop.model_validate({"rate": 50.0, **asked}), os.sched_getaffinity(0))
had = ask(realtime="prefer", priority=3).scheduling
os.setuid(65534)
print(had, "then", ask().scheduling)
"""


def test_priority_is_given_back_without_the_leave_it_took() -> None:
    """As under systemd's LimitRTPRIO: whoever had it granted has no CAP_SYS_NICE when it is turned off."""
    if os.geteuid() != 0:
        pytest.skip("needs a priority to be granted, and the capability to be dropped")
    said = subprocess.run(
        [sys.executable, "-c", WITHOUT_LEAVE], capture_output=True, text=True, check=True, timeout=60
    ).stdout.strip()
    if said.startswith("SCHED_OTHER"):
        pytest.skip("this machine grants no priority, not to root")
    assert said == "SCHED_FIFO 3 then SCHED_OTHER"


def scheduling_of(pid: int) -> dict[int, int]:
    """Policy of each thread of a process."""
    threads = [int(folder.name) for folder in Path(f"/proc/{pid}/task").iterdir()]
    return {thread: os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK for thread in threads}


@pytest.fixture
def preferring() -> Rig:
    asked = {"realtime": "prefer", "processors": (LAST,), "stay_awake": True}
    loop = SHORT.loop.model_copy(update=asked)
    return SHORT.model_copy(update={"loop": loop})


@pytest.mark.process
def test_the_daemon_tells_what_it_has_and_its_other_threads_and_recorder_have_not(
    preferring: Rig, bus: Bus, tmp_path: Path
) -> None:
    with daemon(preferring, bus, tmp_path) as sensor:
        with post(sensor) as rig:
            status = rig.await_status(lambda status: status.slots_run > 0, "a status")
        pid = sensor.process.pid
        threads = scheduling_of(pid)
        loop = threads.pop(pid)
        told = "SCHED_OTHER"
        if loop == os.SCHED_FIFO:
            told = f"SCHED_FIFO {os.sched_getparam(pid).sched_priority}"
        assert (status.realtime, status.scheduling) == ("prefer", told)
        assert status.processors == str(LAST)
        assert os.sched_getaffinity(pid) == {LAST}
        assert set(threads.values()) == {os.SCHED_OTHER}
        assert any(os.sched_getaffinity(thread) == ALL for thread in threads)
        assert set(scheduling_of(sensor.recorder).values()) == {os.SCHED_OTHER}
        assert os.sched_getaffinity(sensor.recorder) == ALL
        assert status.memory_locked == (locked_kib(pid) > 0)
        assert status.kept_awake == (str(DEVICE) in open_files(pid))
        assert str(DEVICE) not in open_files(sensor.recorder)
        assert told in sensor.said
        assert sensor.end(signal.SIGTERM) == 0
        (session,) = sensor.sessions
    assert told_in(session, status)


def locked_kib(pid: int) -> int:
    lines = Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmLck:"))


def told_in(session: Path, status: Status) -> bool:
    metadata = Session(session).metadata
    return (
        metadata["scheduling"] == status.scheduling
        and metadata["loop_processors"] == status.processors
        and metadata["memory_locked"] == ("yes" if status.memory_locked else "no")
        and metadata["kept_awake"] == ("yes" if status.kept_awake else "no")
        and metadata["realtime"] == status.realtime
        and float(metadata["switch_interval_s"]) == realtime.SWITCH_INTERVAL_S
        and int(metadata["garbage_frozen"]) > MODULES
    )
