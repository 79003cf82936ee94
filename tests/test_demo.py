"""The demonstration: real processes, a session left behind, and an account that holds against the truth."""

import csv
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.daemons import free_bus, wait_until
from tests.rigs import BEGUN_NS, NS, RATE, SHORT, samples, simulated
from vsensor.config import effective_toml
from vsensor.demo import Played, account, await_ready, example, how_to_view, on_free_port
from vsensor.errors import VsensorError
from vsensor.messages import BIT_ESTIMATE, SENSOR_TICK
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter
from vsensor.service.engine import Engine
from vsensor.simulate.broadcast import TRUTH_COLUMNS

ERROR = re.compile(r"^  (confirmed|now|forecast) +([0-9.]+) rpm, ([0-9.]+) kN·m$", re.MULTILINE)


def demo(folder: Path, *arguments: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "vsensor.cli.main", "demo", "--headless", *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONWARNINGS": "error::RuntimeWarning"},
    )


def children_of(pid: int) -> list[str]:
    return Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()


def session_of(text: str) -> Session:
    found = re.search(r"^session +(\S+)$", text, re.MULTILINE)
    assert found is not None, text
    return Session(Path(found[1]))


@pytest.mark.parametrize(
    ("does", "complaint"),
    [
        ("print('compiling', flush=True); time.sleep(600)", "the daemon was not ready within 1 s"),
        ("print('compiling')", "the daemon ended before it was ready"),
    ],
)
def test_a_daemon_that_is_not_ready_is_not_waited_for_without_end(does: str, complaint: str) -> None:
    with own(does) as process, pytest.raises(VsensorError, match=complaint):
        await_ready(process, 1.0)


def test_a_daemon_that_is_ready_is_waited_for_no_longer() -> None:
    with own("print('compiling\\nREADY', flush=True); time.sleep(600)") as process:
        await_ready(process)


@contextmanager
def own(does: str) -> "Iterator[subprocess.Popen[str]]":
    command = [sys.executable, "-c", f"import time; {does}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


@pytest.mark.process
def test_six_seconds_without_a_screen(tmp_path: Path) -> None:
    """On our example string, in which six seconds are enough for the first answers."""
    process = demo(tmp_path, "--duration", "6", "--scenario", "smooth")
    said, complaints = process.communicate(timeout=100)
    assert process.returncode == 0, said + complaints
    assert complaints == ""

    (recording,) = (tmp_path / "recordings").iterdir()
    assert f"session             recordings/{recording.name}" in said
    session = Session(recording)
    assert session.complete
    ticks = sum(1 for _ in session.messages((SENSOR_TICK,)))
    assert re.search(rf"^ticks +{ticks}$", said, re.MULTILINE)
    assert re.search(rf"^estimates published +{ticks}$", said, re.MULTILINE)
    assert ticks > 300
    errors = {kind: (float(speed), float(torque)) for kind, speed, torque in ERROR.findall(said)}
    assert errors["confirmed"][0] < 6
    assert errors["confirmed"][1] < 1.5


@pytest.mark.process
def test_ctrl_c_ends_it_with_its_account_and_leaves_no_process_behind(tmp_path: Path) -> None:
    config = tmp_path / "rig.toml"
    config.write_text(effective_toml(SHORT), encoding="utf-8")
    process = demo(tmp_path, str(config), "--duration", "100")
    wait_until(lambda: len(children_of(process.pid)) == 2, "rig and daemon")
    started = children_of(process.pid)
    process.send_signal(signal.SIGINT)
    said, complaints = process.communicate(timeout=60)
    assert process.returncode == 0, complaints
    assert re.search(r"^ticks +[0-9]+$", said, re.MULTILINE)
    assert "too short for an answer" in said
    assert not any(Path(f"/proc/{pid}").exists() for pid in started)


@pytest.mark.process
def test_a_demonstration_that_cannot_record_says_why_and_ends_with_1(tmp_path: Path) -> None:
    (tmp_path / "recordings").write_text("a file where the folder should be")
    process = demo(tmp_path, "--duration", "6")
    _, complaints = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "cannot be created" in complaints
    assert "the daemon ended before it was ready" in complaints
    assert "Traceback" not in complaints


def played(folder: Path, seconds: float, truth_late_s: float = 0.0) -> Played:
    """A session of the short rig, as the daemon would have left it, and the truth, perhaps too late."""
    readings = simulated(seconds)
    engine = Engine(SHORT)
    path = folder / f"{truth_late_s:g}.mcap"
    with SessionWriter(path, configuration="", metadata={"rig": "test"}, compression="zstd") as writer:
        for topic, sample in samples(readings):
            for tick, estimate in engine.take(topic, sample):
                writer.write(SENSOR_TICK, tick.SerializeToString(), tick.time_ns, tick.time_ns)
                writer.write(BIT_ESTIMATE, estimate.SerializeToString(), tick.time_ns, tick.time_ns)
    truth = folder / f"{truth_late_s:g}.csv"
    with truth.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(TRUTH_COLUMNS)
        for r in readings:
            rows.writerow((f"{BEGUN_NS / NS + r.bit_time_s + truth_late_s:.6f}", r.bit_torque, r.bit_speed))
    return Played(path, truth)


def test_the_account_tells_how_near_the_estimates_came(tmp_path: Path) -> None:
    said = account(SHORT, played(tmp_path, 20))
    assert f"ticks               {20 * RATE}\n" in said
    assert re.search(r"severity +[0-9.]+  = \(max − min\) / \(2 mean\) over the last 4 s", said)
    errors = {kind: float(speed) for kind, speed, _ in ERROR.findall(said)}
    assert errors.keys() == {"confirmed", "now", "forecast"}
    assert 0 < errors["confirmed"] < 4
    assert max(errors.values()) < 20


def test_the_account_would_tell_if_they_were_wrong(tmp_path: Path) -> None:
    """Held against a truth that is half a second late, the same estimates are far off."""
    right, wrong = (
        float(ERROR.findall(account(SHORT, played(tmp_path, 20, late_s)))[0][1]) for late_s in (0.0, 0.5)
    )
    assert wrong > 3 * right


def test_what_was_too_short_for_an_answer_is_told_without_one(tmp_path: Path) -> None:
    short = played(tmp_path, 0.5)
    short.truth.unlink()  # the rig may not even have begun to write it
    assert account(SHORT, short).endswith(
        "too short for an answer: the waves need time to reach the bit and return"
    )


def test_the_examples_are_found() -> None:
    assert example("drilling.toml").is_file()
    with pytest.raises(VsensorError, match=r"nowhere\.toml is neither in"):
        example("nowhere.toml")


def test_it_listens_where_no_daemon_at_work_is_disturbed() -> None:
    busy = SHORT.model_copy(update={"bus": free_bus()})
    (endpoint,) = on_free_port(busy).bus.listen
    assert re.fullmatch(r"tcp/127\.0\.0\.1:[0-9]+", endpoint)
    assert endpoint != busy.bus.listen[0]
    assert on_free_port(busy).string == busy.string


@pytest.mark.parametrize(
    ("web", "display", "arguments"), [(False, ":0", []), (False, None, ["--web"]), (True, ":0", ["--web"])]
)
def test_without_a_display_the_view_goes_to_the_browser(
    web: bool, display: str | None, arguments: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.delenv("DISPLAY", raising=False)
    if display is not None:
        monkeypatch.setenv("DISPLAY", display)
    said: list[str] = []
    assert how_to_view(web=web, say=said.append) == arguments
    assert bool(said) == (not web)
