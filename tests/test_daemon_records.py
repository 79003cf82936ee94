"""The daemon's recording on a real bus: parts that stand alone, snapshots, orders, a torn session mended."""

import re
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.daemons import Post, daemon, post, wait_until
from tests.rigs import RATE, SHORT, samples, simulated
from vsensor.bus import command
from vsensor.cli.main import app
from vsensor.config import Bus, Rig
from vsensor.errors import BusError
from vsensor.messages import BIT_ESTIMATE, SENSOR_STATUS, SENSOR_TICK, Estimate
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

pytestmark = pytest.mark.process

SECONDS = 12
FEED = samples(simulated(SECONDS))


def recording(**changed: object) -> Rig:
    settings = SHORT.recording.model_copy(update={"memory": 5.0, "keep_free": 0.0, **changed})
    return SHORT.model_copy(update={"recording": settings})


def send(rig: Post, first: float, last: float) -> None:
    """Send a piece of the feed, and wait until all of it is estimated."""
    rig.send(FEED[round(first * RATE) * 2 : round(last * RATE) * 2])
    ticks = round(last * RATE)
    rig.await_status(lambda status: status.ticks >= ticks, "its ticks")


def tell(rig: Post, words: str) -> str:
    return command(rig.session, rig.prefix, words)


def ticks(session: Session) -> list[int]:
    return [r.message.number for r in session.messages((SENSOR_TICK,))]  # type: ignore[union-attr]


def test_parts_and_snapshots_of_a_running_daemon_can_each_be_run_again(tmp_path: Path, bus: Bus) -> None:
    with daemon(recording(), bus, tmp_path) as sensor, post(sensor) as rig:
        send(rig, 0, 4)
        said = tell(rig, "split recording")
        assert "goes on" in said
        send(rig, 4, 6)
        assert "are being written" in tell(rig, "snapshot")
        send(rig, 6, 8)
        assert "ends here" in tell(rig, "stop recording")
        with pytest.raises(BusError, match="is not recording"):
            tell(rig, "split recording")
        send(rig, 8, 10)
        assert "is to record into" in tell(rig, "start recording")
        with pytest.raises(BusError, match="is recording already, into"):
            tell(rig, "start recording")
        send(rig, 10, 12)
        tell(rig, "longer 28.5 m")
        status = rig.await_status(lambda status: status.recording_parts == 3, "three parts")
        assert status.recording
        assert status.recording_free_bytes > 0
        assert status.recording_memory_s > 0
        assert any(told.inbox_waiting for told in rig.heard(SENSOR_STATUS))  # type: ignore[union-attr]
        status = rig.await_status(lambda status: status.recording_backlog_bytes > 0, "writing to the disk")
        assert status.recorder_queue_bytes < status.recorder_queue_limit_bytes
        rig.await_status(lambda _: ("snapshot", True) in rig.events, "the snapshot")
        assert rig.events.count(("recording", False)) == 2
        assert sensor.end() == 0

    folder = sensor.rig.recording.folder
    *parts, last = sorted(path for path in folder.glob("*.mcap") if "snapshot" not in path.name)
    (snapshot,) = folder.glob("*-snapshot.mcap")
    assert len(parts) == 2
    held = [ticks(Session(path)) for path in (*parts, last)]
    assert [*held[0], *held[1]] == [*range(8 * RATE)]
    assert held[2] == [*range(10 * RATE, 12 * RATE)]
    assert ticks(Session(snapshot))[-1] == 6 * RATE - 1
    for path in (*parts, last, snapshot):
        verdict = verify(Session(path), Engine(sensor.rig))
        assert verdict.exact, (path, verdict)
    estimated_again(parts[1], tmp_path)


def estimated_again(part: Path, folder: Path) -> None:
    """`vsensor estimate` of a later part goes on from where the one before ended."""
    output = folder / "again.mcap"
    done = CliRunner().invoke(app, ["estimate", str(part), "-o", str(output)])
    assert done.exit_code == 0, done.output
    recorded, again = (
        {r.message.time_ns: r.message for r in Session(path).messages((BIT_ESTIMATE,))}
        for path in (part, output)
    )
    assert recorded == again
    assert any(isinstance(e, Estimate) and e.HasField("confirmed_bit_speed_rad_s") for e in again.values())


def test_it_splits_by_itself_and_no_tick_is_between_the_parts(tmp_path: Path, bus: Bus) -> None:
    with daemon(recording(split_every=0.5, memory=0.0), bus, tmp_path) as sensor, post(sensor) as rig:
        for second in range(4):
            send(rig, second, second + 1)
        rig.await_status(lambda status: status.recording_parts >= 3, "three parts")
        assert sensor.end() == 0
    parts = sensor.sessions
    assert [number for part in parts for number in ticks(Session(part))] == [*range(4 * RATE)]
    assert all(verify(Session(part), Engine(sensor.rig)).exact for part in parts if ticks(Session(part)))


def test_what_a_crash_has_torn_is_mended_at_the_next_start(tmp_path: Path, bus: Bus) -> None:
    with daemon(recording(), bus, tmp_path) as sensor, post(sensor) as rig:
        send(rig, 0, 4)
        part = next(sensor.rig.recording.folder.glob("*.part"))
        rig.await_status(lambda status: status.recording_bytes > 50_000, "bytes on the disk")
        shutil.copy(part, tmp_path / "torn")
        assert sensor.end() == 0
    (whole,) = sensor.sessions
    whole.unlink()
    shutil.move(tmp_path / "torn", part)

    with daemon(recording(), bus, tmp_path) as again, post(again) as rig:
        rig.await_status(lambda _: ("session_mended", True) in rig.events, "a session mended")
        assert again.end() == 0
    assert whole in again.sessions
    assert verify(Session(whole), Engine(sensor.rig)).exact
    assert part.with_suffix(".torn").exists()


def test_without_recording_a_snapshot_can_still_be_kept(tmp_path: Path, bus: Bus) -> None:
    with daemon(recording(enabled=False, memory=300.0), bus, tmp_path) as sensor, post(sensor) as rig:
        send(rig, 0, 3)
        rig.await_status(lambda status: status.recording_memory_s >= 2.0, "the recorder's word")
        said = CliRunner().invoke(app, ["tell", str(sensor.config), "snapshot", "5", "min"])
        assert said.exit_code == 0, said.output
        found = re.search(r"the last (\d+) s are being written", said.output)
        assert found, said.output
        assert int(found[1]) < 60, "it began a few seconds ago"
        wait_until(lambda: bool(sensor.sessions), "the snapshot")
        refused = CliRunner().invoke(app, ["tell", str(sensor.config), "snapshot", "2", "m"])
        assert refused.exit_code == 1
        assert "does not measure in s" in refused.output
        assert sensor.end() == 0
    (kept,) = sensor.sessions
    assert verify(Session(kept), Engine(sensor.rig)).exact
