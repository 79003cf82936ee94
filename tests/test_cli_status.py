"""`vsensor status`: what a person sees of a running daemon, and what a script reads."""

import io
import json
import os
import pty
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

from tests.daemons import Daemon, Post, daemon, post, wait_until
from tests.rigs import RATE, SHORT, samples, simulated
from vsensor.cli.main import app
from vsensor.cli.panel import STYLES, Panel
from vsensor.config import Bus
from vsensor.messages import ChannelStatus, Estimate, Event, Status
from vsensor.messages.states import STATES
from vsensor.messages.vsensor_pb2 import UNCERTAIN
from vsensor.quality import Reason


def page(panel: Panel) -> str:
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(panel.shown())
    return console.export_text()


def test_the_page_of_a_sensor_that_has_said_nothing_yet() -> None:
    text = page(Panel(Status(rig="a", state="starting")))
    assert "a  starting" in text
    assert "nothing is recorded" in text


def test_brackets_in_a_name_are_shown() -> None:
    panel = Panel(Status(rig="a", recording="rec[/x]/[red]a.mcap"))
    panel.hear_all(
        [("", Event(time_ns=0, name="session_deleted", begins=True, text="[/x]b.mcap is deleted"))]
    )
    text = page(panel)
    assert "rec[/x]/[red]a.mcap" in text
    assert "[/x]b.mcap is deleted" in text


def test_the_page_tells_what_cannot_be_saved_and_what_the_bus_has_lost() -> None:
    text = page(Panel(Status(rig="a", learned_trouble="state: a file is there", bus_missed=1234)))
    assert "state: a file is there" in text
    assert re.search(r"missed +1,234 +on the bus", text)
    sound = page(Panel(Status(rig="a")))
    assert "missed" not in sound
    assert "not saved" not in sound


def test_what_was_refused_has_not_ended() -> None:
    panel = Panel(Status(rig="a"))
    panel.hear_all([("", Event(name="snapshot", begins=False, text="a.mcap is not kept"))])
    assert re.search(r"refused +snapshot: a.mcap is not kept", page(panel))


def test_each_state_has_its_colour() -> None:
    assert set(STYLES) == set(STATES)


@pytest.mark.parametrize("kept_awake", [True, False])
def test_the_page_tells_what_real_time_was_granted(kept_awake: bool) -> None:
    granted = Status(rig="a", realtime="prefer", scheduling="SCHED_FIFO 40", kept_awake=kept_awake)
    text = page(Panel(granted))
    assert "prefer (SCHED_FIFO 40)" in text
    assert ("processors kept awake" in text) is kept_awake
    assert "memory locked" not in text


def test_the_page_tells_what_is_wrong() -> None:
    channel = ChannelStatus(channel="surface/torque", accepted=1200, late=3, jumped=1, lost=2, age_s=4.0)
    status = Status(rig="a", state="input lost", channels=[channel], recording_trouble="the disk is full")
    panel = Panel(status)
    estimate = Estimate(now_bit_speed_rad_s=10.0, now_bit_speed_std_rad_s=1.0, quality=UNCERTAIN)
    estimate.reasons = Reason.STALE_TORQUE | Reason.GAP_BRIDGED
    event = Event(time_ns=0, name="input_lost", begins=True, text="a surface channel is silent")
    panel.hear_all([("bit/estimate", estimate), ("sensor/event", event)])
    text = page(panel)
    for words in (
        "input lost",
        "1,200",
        "late 3, jumped 1",
        "4.00 s",
        "the disk is full",
        "95.5 ± 9.5",
        "uncertain: gap bridged, stale torque",
        "begins",
        "input_lost: a surface channel is silent",
    ):
        assert words in text


@pytest.fixture(scope="module")
def sensor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Daemon]:
    from tests.daemons import free_bus

    with daemon(SHORT, free_bus(), tmp_path_factory.mktemp("status")) as started, post(started) as rig:
        feed(rig)
        yield started


def feed(rig: Post) -> None:
    rig.send(samples(simulated(4), time.time_ns()))
    rig.await_status(lambda status: status.ticks >= 4 * RATE - 5, "ticks")


@pytest.mark.process
def test_json_is_the_status_as_it_is_on_the_bus(sensor: Daemon) -> None:
    done = CliRunner().invoke(app, ["status", str(sensor.config), "--json"])
    assert done.exit_code == 0, done.output
    told = json.loads(done.output)
    assert told["rig"] == SHORT.rig.name
    assert int(told["ticks"]) >= 4 * RATE - 5


@pytest.mark.process
def test_in_a_pipe_it_is_shown_once(sensor: Daemon) -> None:
    done = CliRunner().invoke(app, ["status", str(sensor.config)])
    assert done.exit_code == 0, done.output
    assert "surface/torque" in done.output
    assert "\x1b" not in done.output


@pytest.mark.process
def test_on_a_terminal_it_goes_on_until_it_is_ended(sensor: Daemon) -> None:
    ours, theirs = pty.openpty()
    shown = subprocess.Popen(
        [sys.executable, "-m", "vsensor.cli.main", "status", str(sensor.config)],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        env=os.environ | {"TERM": "xterm", "COLUMNS": "120", "LINES": "50"},
    )
    os.close(theirs)
    seen = b""
    deadline = time.monotonic() + 60
    while seen.count(b"woken late") < 3 and time.monotonic() < deadline:
        seen += os.read(ours, 1 << 16)
    shown.terminate()
    wait_until(lambda: shown.poll() is not None, "its end")
    os.close(ours)
    assert shown.returncode == 0
    assert seen.count(b"woken late") >= 3


@pytest.mark.process
def test_where_no_sensor_is_up_it_says_so(tmp_path: Path, bus: Bus) -> None:
    from vsensor.config import effective_toml

    config = tmp_path / "rig.toml"
    config.write_text(effective_toml(SHORT.model_copy(update={"bus": bus})), encoding="utf-8")
    done = CliRunner().invoke(app, ["status", str(config)])
    assert done.exit_code == 1
    assert "is the daemon (vsensor run) up?" in done.output
