"""The log of a daemon at work: each trouble has its line, each answer too, all of the same form."""

import json
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.daemons import Daemon, Post, daemon, post, wait_until
from tests.rigs import SHORT
from vsensor.bus import command
from vsensor.cli.log import BURST
from vsensor.config import Bus, effective_toml
from vsensor.messages import SENSOR_EVENT, SURFACE_SPEED, SURFACE_TORQUE

pytestmark = pytest.mark.process


@pytest.fixture
def sensor(bus: Bus, tmp_path: Path) -> Iterator[Daemon]:
    with daemon(SHORT, bus, tmp_path, "--log", "json") as started:
        yield started


@pytest.fixture
def near(sensor: Daemon) -> Iterator[Post]:
    with post(sensor) as joined:
        yield joined


def lines(sensor: Daemon, event: str = "") -> list[dict[str, object]]:
    """All that it has said, or of one event; ValueError where a line is not of the form asked for."""
    told = [json.loads(line) for line in sensor.said.splitlines(keepends=True) if line.endswith("\n")]
    return [line for line in told if not event or line["event"] == event]


def one(sensor: Daemon, event: str) -> dict[str, object]:
    wait_until(lambda: bool(lines(sensor, event)), event)
    return lines(sensor, event)[-1]


def test_each_channels_unreadable_samples_are_told_with_what_was_wrong_with_them(
    sensor: Daemon, near: Post
) -> None:
    for topic, payload in ((SURFACE_TORQUE, b"{"), (SURFACE_SPEED, b'{"time_ns": "1", "value": "fast"}')):
        near.session.put(f"{near.prefix}/{topic}", payload, encoding="application/json")
    torque, speed = (one(sensor, f"{topic} unreadable") for topic in (SURFACE_TORQUE, SURFACE_SPEED))
    assert torque["last"] != speed["last"]
    assert "fast" in str(speed["last"])
    assert "fast" not in str(torque["last"])


def test_each_sighup_is_answered_and_a_refusal_is_a_warning(sensor: Daemon, near: Post) -> None:
    rates = [SHORT.loop.rate + more for more in range(1, BURST + 3)]
    for number, rate in enumerate(rates):
        loop = SHORT.loop.model_copy(update={"rate": rate})
        sensor.config.write_text(effective_toml(sensor.rig.model_copy(update={"loop": loop})))
        sensor.process.send_signal(signal.SIGHUP)
        wait_until(lambda n=number: _answers(near) > n, "an answer")  # type: ignore[misc]
    wait_until(lambda: len(lines(sensor, "configuration")) == len(rates), "its line", 10)
    told = lines(sensor, "configuration")
    assert all(f"→ {rate}" in str(line["text"]) for rate, line in zip(rates, told, strict=True))
    assert {line["level"] for line in told} == {"warning"}


def _answers(near: Post) -> int:
    return sum(name == "configuration" for name, _ in near.events)


def test_what_was_learned_and_cannot_be_saved_is_told_at_once(sensor: Daemon, near: Post) -> None:
    command(near.session, near.prefix, "longer 28.5 m")  # is saved at once
    near.await_status(lambda status: status.HasField("learned_saved_ns"), "a first saving")
    shutil.rmtree(sensor.rig.state.folder)
    sensor.rig.state.folder.touch()
    command(near.session, near.prefix, "longer 28.5 m")
    told = one(sensor, "what is learned is not saved")
    assert told["level"] == "error"
    assert str(sensor.rig.state.folder) in str(told["why"])
    sensor.rig.state.folder.unlink()
    command(near.session, near.prefix, "longer 28.5 m")
    one(sensor, "what is learned is saved again")


def test_what_goes_wrong_in_the_recorder_is_told_once_and_in_the_form_of_all_lines(
    sensor: Daemon, near: Post
) -> None:
    folder = sensor.rig.recording.folder
    shutil.rmtree(folder)
    folder.touch()
    wait_until(lambda: "a file is in the way" in sensor.said, "word of it")
    near.await_status(lambda status: status.HasField("recording_trouble"), "trouble")
    assert all(line["time"] and line["rig"] == SHORT.rig.name for line in lines(sensor))
    assert ("recording", False) in near.events
    assert near.heard(SENSOR_EVENT)
    assert sensor.end() == 0
    assert lines(sensor, "ended")
