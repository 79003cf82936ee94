"""The recorder beside the loop: nothing it suffers makes the loop wait, nothing is lost uncounted."""

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from vsensor.errors import InputError
from vsensor.messages import SURFACE_TORQUE, Sample, State
from vsensor.recording.reader import Session
from vsensor.recording.recorder import Recorder
from vsensor.recording.recover import recover
from vsensor.recording.wire import PACKET_BYTES

pytestmark = pytest.mark.process

PAYLOAD = Sample(value=1.0, sequence=1).SerializeToString()


def start(path: Path) -> Recorder:
    return Recorder(path, configuration="[rig]", metadata={"rig": "r"}, compression="zstd")


def send(recorder: Recorder, slots: int, messages: int = 6) -> None:
    for slot in range(slots):
        for _ in range(messages):
            recorder.offer(SURFACE_TORQUE, PAYLOAD, slot, slot)
        recorder.send()


def until(true: Callable[[], bool], seconds: float = 20.0) -> None:
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline, "did not happen in time"
        time.sleep(0.02)


def readable(path: Path) -> int:
    return sum(1 for _ in Session(path).messages())


def test_what_is_sent_is_in_the_file_in_its_order(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    for number in range(3000):
        sample = Sample(time_ns=number, value=number / 7, sequence=number)
        recorder.offer(SURFACE_TORQUE, sample.SerializeToString(), number + 10**9, number)
        if number % 5 == 0:
            recorder.send()

    assert recorder.close(20)

    session = Session(tmp_path / "a.mcap")
    found = list(session.messages())
    assert [record.message.time_ns for record in found] == list(range(3000))
    assert [record.log_time_ns for record in found] == list(range(10**9, 10**9 + 3000))
    assert (recorder.sent, recorder.dropped) == (3000, 0)
    assert session.configuration == "[rig]"
    assert session.recorder == {
        "written": "3000",
        "dropped_by_daemon": "0",
        "dropped_by_recorder": "0",
        "ended": "closed by the daemon",
    }


def test_a_slot_of_more_than_a_packet_is_split(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    send(recorder, slots=1, messages=PACKET_BYTES // 20)
    assert recorder.close(20)
    assert readable(tmp_path / "a.mcap") == recorder.sent == PACKET_BYTES // 20


def test_what_cannot_be_recorded_is_counted(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    recorder.offer("rig/colour", b"", 0, 0)
    recorder.offer(SURFACE_TORQUE, bytes(PACKET_BYTES), 0, 0)
    recorder.offer(SURFACE_TORQUE, PAYLOAD, 0, 0)
    assert recorder.close(20)
    assert (recorder.sent, recorder.dropped) == (1, 2)
    assert Session(tmp_path / "a.mcap").summary().dropped == 2


def test_a_session_that_exists_is_not_written_over_at_the_start(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"precious")
    recorder = start(tmp_path / "a.mcap")
    send(recorder, slots=1)
    assert recorder.close(20)
    assert (tmp_path / "a.mcap").read_bytes() == b"precious"
    assert readable(tmp_path / "a-2.mcap") == recorder.sent > 0


def test_a_session_that_cannot_be_created_is_refused_at_the_start(tmp_path: Path) -> None:
    (tmp_path / "folder").touch()
    with pytest.raises(InputError, match=r"cannot be created"):
        start(tmp_path / "folder" / "a.mcap")


def test_a_frozen_recorder_costs_messages_and_no_time(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    os.kill(recorder.pid, signal.SIGSTOP)
    try:
        slots = 0
        while not recorder.dropped:  # would hang here if it waited
            send(recorder, slots=1)
            slots += 1
        send(recorder, slots=100)
        assert recorder.dropped > 100
        recorder.look()
        told = recorder.figures
        assert told["recorder_queue_bytes"] > 0.9 * told["recorder_queue_limit_bytes"]
        assert recorder.alive
        assert recorder.sent + recorder.dropped == 6 * (slots + 100)
        assert not recorder.close(0.2)
        assert f"still being written by process {recorder.pid}" in recorder.trouble()
    finally:
        os.kill(recorder.pid, signal.SIGCONT)

    def read() -> bool:
        recorder.look()
        return recorder.figures["recorder_queue_bytes"] == 0

    until(read)
    assert recorder.close(20)
    assert recorder.trouble() == ""
    assert readable(tmp_path / "a.mcap") == recorder.sent


def test_a_killed_recorder_loses_no_more_than_its_last_second(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    part = tmp_path / "a.mcap.part"
    send(recorder, slots=100)
    until(lambda: readable(part) == 600)  # by no doing of ours: it syncs by itself
    send(recorder, slots=10)
    os.kill(recorder.pid, signal.SIGKILL)

    def noticed() -> bool:
        send(recorder, slots=1)
        return not recorder.alive

    until(noticed)
    recorder.look()
    send(recorder, slots=50)

    assert recorder.dropped >= 300
    assert "vsensor recover" in recorder.trouble()
    assert not recorder.close(20)
    assert recover(part).messages >= 600


def test_files_that_begin_later_tell_what_it_was_described_as_meanwhile(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    send(recorder, slots=1)
    larger_than_a_packet = "#" * (3 * PACKET_BYTES)
    recorder.describe(larger_than_a_packet, {"realtime": "prefer"})
    assert recorder.checkpoint("split", str(tmp_path / "b.mcap"), State(), [])
    send(recorder, slots=1)
    assert recorder.close(20)

    first, second = Session(tmp_path / "a.mcap"), Session(tmp_path / "b.mcap")
    assert (first.configuration, second.configuration) == ("[rig]", larger_than_a_packet)
    assert "realtime" not in first.metadata
    assert (second.metadata["rig"], second.metadata["realtime"]) == ("r", "prefer")


def test_one_that_died_is_told_when_it_is_back(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    os.kill(recorder.pid, signal.SIGKILL)
    until(lambda: not (recorder.look() or recorder.alive))
    recorder.describe("[rig]  # later", {})
    until(lambda: bool(recorder.look()) or recorder.alive)
    assert recorder.checkpoint("start", str(tmp_path / "b.mcap"), State(), [])
    send(recorder, slots=1)
    assert recorder.close(20)
    assert Session(tmp_path / "b.mcap").configuration == "[rig]  # later"


def test_the_file_is_completed_when_the_daemon_is_killed(tmp_path: Path) -> None:
    code = """
import sys, time
from pathlib import Path
from vsensor.recording.recorder import Recorder
recorder = Recorder(Path(sys.argv[1]), configuration="", metadata={"rig": "r"}, compression="zstd")
for number in range(500):
    recorder.offer("surface/torque", b"", number, number)
    recorder.send()
print("sent", flush=True)
time.sleep(60)
"""
    daemon = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path / "a.mcap")], stdout=subprocess.PIPE, text=True
    )
    with daemon:
        assert daemon.stdout is not None
        assert daemon.stdout.readline() == "sent\n"
        daemon.kill()

    until((tmp_path / "a.mcap").exists)
    session = Session(tmp_path / "a.mcap")
    assert len(list(session.messages())) == 500
    assert session.recorder["dropped_by_daemon"] == "unknown"
    assert session.recorder["ended"] == "the daemon ended without closing it"


def test_ctrl_c_at_the_terminal_does_not_end_it(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    assert os.getsid(recorder.pid) != os.getsid(0)
    os.kill(recorder.pid, signal.SIGINT)
    send(recorder, slots=10)
    assert recorder.close(20)
    assert readable(tmp_path / "a.mcap") == 60


def test_told_to_end_it_completes_the_file_with_what_it_was_sent(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    send(recorder, slots=100)
    os.kill(recorder.pid, signal.SIGTERM)
    until((tmp_path / "a.mcap").exists)
    send(recorder, slots=5)

    assert not recorder.alive
    assert recorder.dropped == 30
    assert recorder.close(20)
    session = Session(tmp_path / "a.mcap")
    assert len(list(session.messages())) == 600
    assert session.recorder["ended"] == "the recorder was told to end"


def test_a_full_disk_is_told_and_keeps_what_was_written(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    recorder = start(tmp_path / "a.mcap")
    part = tmp_path / "a.mcap.part"
    send(recorder, slots=100)
    until(lambda: readable(part) == 600)
    resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (part.stat().st_size + 10, resource.RLIM_INFINITY))
    assert recorder.trouble() == ""
    send(recorder, slots=100)

    until(lambda: bool(recorder.look()) and recorder.trouble() != "")

    assert "File too large" in recorder.trouble()
    assert "vsensor recover" in recorder.trouble()
    assert recorder.alive
    assert recorder.path == ""
    send(recorder, slots=10)
    until(lambda: recorder.look() == [] and recorder.dropped >= 660)
    assert not recorder.close(20)
    assert "File too large" in recorder.trouble()
    assert capfd.readouterr().err == "", "the daemon's log tells it"
    assert recover(part, tmp_path / "b.mcap").messages >= 600


def test_a_disk_that_fills_at_the_very_end_is_told(tmp_path: Path) -> None:
    recorder = start(tmp_path / "a.mcap")
    part = tmp_path / "a.mcap.part"
    resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (part.stat().st_size + 10, resource.RLIM_INFINITY))
    send(recorder, slots=1)

    assert not recorder.close(20)

    assert "File too large" in recorder.trouble()
    assert part.exists()


def test_the_recorders_process_loads_neither_zenoh_nor_numba() -> None:
    heavy = "{'zenoh', 'numba', 'numpy', 'pyarrow', 'pydantic', 'rerun'}"
    code = f"import vsensor.recording.process, sys; print({heavy} & sys.modules.keys())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
