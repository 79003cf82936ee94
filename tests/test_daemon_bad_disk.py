"""A disk that is slow, or refuses all writes: the loop does not notice, and what is not kept is counted."""

import errno
import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest

from tests.daemons import PATIENCE_S, wait_until
from tests.live import at_work, others, undisturbed
from tests.rigs import SHORT
from vsensor.config import Bus
from vsensor.messages import SENSOR_TICK, SURFACE_TORQUE, Sample, Tick
from vsensor.messages.surface import MAX_BYTES
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler here"),
]

SOURCE = Path(__file__).with_name("bad_disk.c")
WRITE_S = 3
"""What each write takes; a turn of the loop that waited for one would be as long."""
LARGE = MAX_BYTES - 100


@pytest.fixture
def bad(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The disk of the recordings is bad for processes started from now on, while this file is there."""
    library = tmp_path / "bad_disk.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, SOURCE, "-ldl"], check=True)
    flag = tmp_path / "bad"
    monkeypatch.setenv("LD_PRELOAD", str(library))
    monkeypatch.setenv("BAD_FOLDER", str(tmp_path / "recordings"))
    monkeypatch.setenv("BAD_WHILE", str(flag))
    return flag


def large(time_ns: int) -> Sample:
    """A sample as large as they are taken, and no smaller when compressed: many fill the room in seconds."""
    unknown = b"\xc2\x3e" + bytes([LARGE & 0x7F | 0x80, LARGE >> 7]) + os.urandom(LARGE)  # field 1000, bytes
    return Sample.FromString(Sample(time_ns=time_ns, value=1.0).SerializeToString() + unknown)


def test_a_slow_disk_costs_messages_that_are_counted_and_no_turn(
    bad: Path, bus: Bus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BAD_SECONDS", str(WRITE_S))
    with at_work(bus, tmp_path) as (sensor, near, rig):
        before = near.await_status(lambda status: status.ticks == rig.readings, "ticks")
        bad.touch()
        rig.live(2)
        flood_until = time.monotonic() + PATIENCE_S
        while not near.await_status(lambda _: True, "a status").recorder_dropped:
            near.send([(SURFACE_TORQUE, large(rig.sent[0][1].time_ns)) for _ in range(2000)])
            rig.live(0.5)
            assert time.monotonic() < flood_until, "nothing of it was dropped"
        rig.live(2 * WRITE_S)
        status = near.await_status(lambda status: status.ticks == rig.readings, "ticks meanwhile")
        assert status.recorder_dropped
        for name in ("lateness", "work"):
            told, earlier = getattr(status, name), getattr(before, name)
            long = [
                upper
                for now, then, upper in zip(told.counts, earlier.counts, [0, *told.upper_s], strict=False)
                if now > then and upper >= WRITE_S
            ]
            assert long == [], name
        bad.unlink()
        rig.live(2)
        near.await_status(lambda status: status.ticks == rig.readings, "ticks afterwards")
        assert others(near.estimates, undisturbed(rig.sent)) == []
        assert sensor.end() == 0
        (path,) = sensor.sessions
        told_by_daemon = int(sensor.said.rpartition("not_recorded=")[2].split()[0])
    recorded = Session(path)
    assert recorded.complete
    assert not verify(recorded, Engine(SHORT)).mismatches
    dropped = sum(int(recorded.recorder[f"dropped_by_{who}"]) for who in ("daemon", "recorder"))
    assert dropped == told_by_daemon > 0
    ticks = sum(isinstance(r.message, Tick) for r in recorded.messages((SENSOR_TICK,)))
    assert ticks <= rig.readings <= ticks + dropped


def test_a_disk_that_becomes_read_only_ends_the_recording_until_it_can_be_written_on_again(
    bad: Path, bus: Bus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As ext4 does to itself after an error (errors=remount-ro). What stood on it by then is mended."""
    monkeypatch.setenv("BAD_ERRNO", str(errno.EROFS))
    with at_work(bus, tmp_path) as (sensor, near, rig):
        near.await_status(lambda status: status.ticks == rig.readings, "ticks")
        bad.touch()
        rig.live(2)
        status = near.await_status(lambda status: status.HasField("recording_trouble"), "trouble told")
        assert "Read-only file system" in status.recording_trouble
        assert not status.HasField("recording")
        bad.unlink()
        near.await_status(lambda status: status.HasField("recording"), "another recording")
        rig.live(2)
        status = near.await_status(lambda status: status.ticks == rig.readings, "all ticks")
        assert others(near.estimates, undisturbed(rig.sent)) == []
        wait_until(lambda: len(list((tmp_path / "recordings").glob("*.torn"))) == 1, "the torn session kept")
        assert sensor.end() == 0
        torn, anew = (Session(path) for path in sorted(sensor.sessions))
    assert verify(torn, Engine(SHORT)).exact
    assert anew.complete
    assert verify(anew, Engine(SHORT)).exact
