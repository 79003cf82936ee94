"""Faults around a daemon at work: disks full, read-only or slow, a listener that stands still, silence."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.daemons import Daemon, daemon, post, wait_until
from tests.live import others, undisturbed
from tests.rigs import RATE, SHORT, Surface, samples, simulated
from vsensor.config import Bus
from vsensor.messages import SENSOR_TICK, SURFACE_SPEED, Status, Tick
from vsensor.messages.vsensor_pb2 import GOOD
from vsensor.quality import Reason
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

pytestmark = pytest.mark.process

READINGS = simulated(12)
ROOM = 600 * 1024
"""Of a small disk."""
SEEN_BYTES = 50_000
"""More than a view writes that hears nothing."""


@contextmanager
def disk(place: Path, options: str) -> Iterator[Path]:
    """A file system of its own in memory; where none may be mounted the test is skipped, and says so."""
    place.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(place)], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip(f"no file system can be mounted here: {mounted.stderr.decode().strip()}")
    try:
        yield place
    finally:
        subprocess.run(["umount", "--lazy", str(place)], check=True)


def seconds(begin: int, end: int, begun_ns: int) -> Surface:
    """Part of the feed."""
    return samples(READINGS, begun_ns)[begin * 2 * RATE : end * 2 * RATE]


def test_a_disk_that_is_full_ends_the_recording_and_nothing_else(bus: Bus, tmp_path: Path) -> None:
    settings = SHORT.recording.model_copy(update={"keep_free": 0.0, "compression": "none"})
    rig = SHORT.model_copy(update={"recording": settings})
    with disk(tmp_path / "recordings", f"size={ROOM}"), daemon(rig, bus, tmp_path) as sensor:
        with post(sensor) as joined:
            joined.send(seconds(0, 12, time.time_ns()))
            status = joined.await_status(lambda status: not status.HasField("recording"), "a full disk")
            status = joined.await_status(lambda status: status.ticks == len(READINGS), "all ticks")
            assert status.published == len(READINGS)
        assert "No space left on device" in sensor.said
        assert sensor.end(signal.SIGTERM) == 0
        assert "Traceback" not in sensor.said


def test_what_cannot_be_kept_on_a_read_only_disk_is_told_and_all_else_goes_on(
    bus: Bus, tmp_path: Path
) -> None:
    with disk(tmp_path / "state", "ro"), daemon(SHORT, bus, tmp_path) as sensor:
        with post(sensor) as joined:
            joined.send(seconds(0, 4, time.time_ns()))
            joined.await_status(lambda status: status.ticks == 4 * RATE, "ticks")
        assert sensor.end(signal.SIGTERM) == 0
        assert "Read-only file system" in sensor.said
        (session,) = sensor.sessions
    assert verify(Session(session), Engine(SHORT)).exact


def test_a_session_cannot_be_begun_on_a_read_only_disk_and_nothing_starts(bus: Bus, tmp_path: Path) -> None:
    with disk(tmp_path / "recordings", "ro"):
        started = Daemon(SHORT, bus, tmp_path)
        assert started.process.wait(60) == 1
        assert "Read-only file system" in started.said
        assert "READY" not in started.said


def test_a_view_and_a_recorder_that_stand_still_hold_nothing_up(bus: Bus, tmp_path: Path) -> None:
    """No put waits for them, nor for a view that is killed; each tick comes, what is lost is counted."""
    seen = tmp_path / "seen.rrd"
    with daemon(SHORT, bus, tmp_path) as sensor, post(sensor) as joined:
        with _view(sensor, seen) as viewer:
            begun_ns = time.time_ns()
            joined.send(seconds(0, 4, begun_ns))
            joined.await_status(lambda status: status.ticks == 4 * RATE, "ticks")
            wait_until(lambda: seen.stat().st_size > SEEN_BYTES, "what the view has heard")
            stopped = (viewer.pid, sensor.recorder)
            for pid in stopped:
                os.kill(pid, signal.SIGSTOP)
            joined.send(seconds(4, 8, begun_ns))
            joined.await_status(lambda status: status.ticks == 8 * RATE, "ticks meanwhile")
            for pid in stopped:
                os.kill(pid, signal.SIGCONT)
            joined.send(seconds(8, 10, begun_ns))
            joined.await_status(lambda status: status.ticks == 10 * RATE, "ticks afterwards")
            viewer.kill()
            viewer.wait()
            joined.send(seconds(10, 12, begun_ns))
            status = joined.await_status(lambda status: status.ticks == 12 * RATE, "ticks without a view")
        waited = [
            n for n, upper in zip(status.publish.counts, status.publish.upper_s, strict=False) if upper > 2
        ]
        assert sum(waited) == 0
        assert sensor.end(signal.SIGTERM) == 0
        (path,) = sensor.sessions
    session = Session(path)
    assert not verify(session, Engine(SHORT)).mismatches
    recorded = sum(isinstance(record.message, Tick) for record in session.messages((SENSOR_TICK,)))
    assert recorded == 12 * RATE or session.recorder["dropped_by_daemon"] != "0"


def test_a_rig_that_was_started_again_counts_from_0_and_nothing_comes_of_it(bus: Bus, tmp_path: Path) -> None:
    begun_ns = time.time_ns()
    runs = [samples(part, begun_ns) for part in (READINGS[: 5 * RATE], READINGS[5 * RATE :])]
    with daemon(SHORT, bus, tmp_path) as sensor, post(sensor) as near:
        for sent, ticks in zip(runs, (5 * RATE, len(READINGS)), strict=True):
            with post(sensor) as rig:
                rig.send(sent)
                status = near.await_status(_reached(ticks), "ticks")
        assert [(c.accepted, c.lost) for c in status.channels] == [(len(READINGS), 0)] * 2
        assert others(near.estimates, undisturbed([*runs[0], *runs[1]])) == []


@contextmanager
def _view(of: Daemon, into: Path) -> Iterator[subprocess.Popen[str]]:
    """`vsensor view` of this daemon, once it looks on."""
    command = [sys.executable, "-m", "vsensor.cli.main", "view", str(of.config), "--save", str(into)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as view:
        try:
            assert view.stdout is not None
            assert "written to" in view.stdout.readline()
            yield view
        finally:
            view.kill()


def test_while_a_channel_is_silent_nothing_is_called_good(bus: Bus, tmp_path: Path) -> None:
    with daemon(SHORT, bus, tmp_path) as sensor, post(sensor) as joined:
        begun_ns = time.time_ns()
        joined.send(seconds(0, 6, begun_ns))
        joined.send([each for each in seconds(6, 8, begun_ns) if each[0] != SURFACE_SPEED])
        wait_until(
            lambda: any(estimate.reasons & Reason.STALE_SPEED for estimate in joined.estimates), "staleness"
        )
        ticks = joined.await_status(lambda status: status.state == "input lost", "the loss of input").ticks
        joined.send(seconds(8, 12, begun_ns))
        joined.await_status(_goes_on(ticks), "its return")
        for estimate in joined.estimates:
            if estimate.reasons & (Reason.STALE_SPEED | Reason.STALE_TORQUE | Reason.WARMING_UP):
                assert estimate.quality != GOOD


def _reached(ticks: int) -> Callable[[Status], bool]:
    return lambda status: status.ticks == ticks


def _goes_on(ticks: int) -> Callable[[Status], bool]:
    return lambda status: status.ticks > ticks + 2 * RATE
