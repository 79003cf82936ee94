"""How a daemon ends, and what it outlives: signals, a dead recorder, a pause, faults at the start."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.daemons import Daemon, Post, daemon, post, wait_until
from tests.rigs import RATE, SHORT, Surface, samples, simulated
from vsensor.config import Bus
from vsensor.messages import SENSOR_TICK, Status, Tick
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

pytestmark = pytest.mark.process

READINGS = simulated(6)


@pytest.fixture
def sensor(tmp_path: Path, bus: Bus) -> Iterator[Daemon]:
    with daemon(SHORT, bus, tmp_path) as started:
        yield started


@pytest.fixture
def rig(sensor: Daemon) -> Iterator[Post]:
    with post(sensor) as joined:
        yield joined


@pytest.fixture
def feed() -> Surface:
    return samples(READINGS, time.time_ns())


def run(rig: Post, feed: Surface) -> Status:
    """Feed it, and wait until each sample has become a tick."""
    rig.send(feed)
    return rig.await_status(lambda status: status.ticks >= feed[-1][1].sequence, "ticks of all samples")


def complete(sensor: Daemon) -> Session:
    """The session that it leaves, once it is there and complete."""
    wait_until(lambda: len(sensor.sessions) == 1, "a complete session")
    session = Session(sensor.sessions[0])
    assert session.complete
    return session


def ticks(session: Session) -> list[Tick]:
    return [r.message for r in session.messages((SENSOR_TICK,)) if isinstance(r.message, Tick)]


def run_by_hand(config: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "vsensor.cli.main", "run", str(config)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env=os.environ | {"COLUMNS": "200"},
    )


def test_what_waited_when_it_was_told_to_end_is_still_run(sensor: Daemon, rig: Post) -> None:
    """More comes at once than a turn may take; the word to end comes while the most of it waits."""
    flood = samples(simulated(120), time.time_ns())
    rig.send(flood)
    time.sleep(0.5)  # all of it has come
    sensor.end(signal.SIGTERM)
    assert len(ticks(complete(sensor))) >= flood[-1][1].sequence


def test_sigterm_ends_it_as_well_as_ctrl_c_and_a_second_daemon_is_refused_meanwhile(
    sensor: Daemon, rig: Post, feed: Surface
) -> None:
    run(rig, feed)
    second = run_by_hand(sensor.config)
    assert second.returncode == 1
    assert f"no bus at {sensor.rig.bus.listen[0]}: is the port taken?" in second.stderr
    assert "Traceback" not in second.stderr

    assert sensor.end(signal.SIGTERM) == 0
    session = complete(sensor)
    assert verify(session, Engine(SHORT)).exact
    assert len(ticks(session)) == len(READINGS)
    assert f"ticks={len(READINGS)} published={len(READINGS)} not_recorded=0" in sensor.said


def test_where_the_daemon_is_killed_the_recorder_completes_the_session(
    sensor: Daemon, rig: Post, feed: Surface
) -> None:
    run(rig, feed)
    sensor.end(signal.SIGKILL)
    session = complete(sensor)
    assert session.recorder["ended"] == "the daemon ended without closing it"
    assert len(ticks(session)) == len(READINGS)
    assert verify(session, Engine(SHORT)).exact


def test_where_the_recorder_is_killed_the_daemon_goes_on_and_says_so(
    sensor: Daemon, rig: Post, feed: Surface
) -> None:
    before = run(rig, feed[: 3 * 2 * RATE])
    assert before.recording
    os.kill(sensor.recorder, signal.SIGKILL)
    after = run(rig, feed[3 * 2 * RATE :])
    assert after.ticks == len(READINGS)
    told = rig.await_status(lambda status: not status.HasField("recording"), "a status without recording")
    assert told.recorder_dropped > 0
    assert "no longer recorded" in sensor.said
    assert "vsensor recover" in sensor.said

    rig.await_status(lambda status: status.HasField("recording"), "another recorder")
    rig.await_status(lambda _: ("session_mended", True) in rig.events, "the torn session mended")
    assert sensor.end(signal.SIGTERM) == 0
    mended, second = sensor.sessions
    assert verify(Session(mended), Engine(SHORT)).exact
    assert Session(second).complete
    assert list(sensor.rig.recording.folder.glob("*.mcap.torn"))


def test_a_pause_loses_no_tick_and_those_made_up_for_say_so(sensor: Daemon, rig: Post, feed: Surface) -> None:
    run(rig, feed[: 3 * 2 * RATE])
    sensor.process.send_signal(signal.SIGSTOP)
    rig.send(feed[3 * 2 * RATE :])
    time.sleep(1.5)  # the pause itself: slots must pass without a turn
    sensor.process.send_signal(signal.SIGCONT)
    after = rig.await_status(lambda status: status.ticks >= len(READINGS), "the ticks of the pause")
    assert after.slots_skipped >= RATE
    assert after.slots_due == after.slots_run + after.slots_skipped
    assert after.restarts == 0

    assert sensor.end(signal.SIGTERM) == 0
    session = complete(sensor)
    run_ticks = ticks(session)
    assert [tick.number for tick in run_ticks] == list(range(len(READINGS)))
    assert all(tick.HasField("slot") and tick.HasField("lateness_ns") for tick in run_ticks)
    caught_up = [tick.number for tick in run_ticks if tick.caught_up]
    assert any(number >= 3 * RATE - 1 for number in caught_up)
    assert verify(session, Engine(SHORT)).exact


def test_a_faulty_configuration_is_told_as_a_whole_and_nothing_starts(tmp_path: Path) -> None:
    config = tmp_path / "rig.toml"
    config.write_text(
        '[rig]\nname = "a b"\n[[string]]\nlength = "5 kg"\nouter_diameter = 0.1\ninner_diameter = 0\n'
        "[loop]\nrate = 0\n[typo]\n"
    )
    ended = run_by_hand(config)
    assert ended.returncode == 2
    for fault in ("rig.name", "length", "loop.rate", "typo"):
        assert fault in ended.stderr
    assert "Traceback" not in ended.stderr
    assert "READY" not in ended.stdout


def test_a_folder_that_cannot_be_written_is_named_and_nothing_starts(tmp_path: Path, bus: Bus) -> None:
    (tmp_path / "recordings").write_text("a file where the folder should be")
    started = Daemon(SHORT, bus, tmp_path)
    assert started.process.wait(60) == 1
    assert f"{tmp_path / 'recordings'}" in started.said
    assert "cannot be created" in started.said
    assert "Traceback" not in started.said
    assert "READY" not in started.said


def test_without_recording_it_runs_and_leaves_no_file(tmp_path: Path, bus: Bus) -> None:
    silent = SHORT.model_copy(update={"recording": SHORT.recording.model_copy(update={"enabled": False})})
    with daemon(silent, bus, tmp_path) as started, post(started) as joined:
        status = run(joined, samples(READINGS))
        assert not status.HasField("recording")
        assert started.end(signal.SIGTERM) == 0
    assert not started.rig.recording.folder.exists()
