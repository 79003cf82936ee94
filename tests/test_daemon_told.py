"""The driller tells a running daemon what only he knows; depths come over the bus."""

import time
from pathlib import Path
from typing import cast

import pytest
from typer.testing import CliRunner

from tests.daemons import Daemon, Post, daemon, free_bus, post, wait_until
from tests.rigs import NS, RATE, SHORT, samples, simulated
from vsensor.cli import main
from vsensor.commands import COMMAND
from vsensor.config import Bus, effective_toml, loads
from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_TICK,
    SURFACE_BIT_DEPTH,
    SURFACE_HOLE_DEPTH,
    Event,
    Sample,
    Tick,
)
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

pytestmark = pytest.mark.process
LENGTH = SHORT.string[0].length


def say(sensor: Daemon, *words: str) -> tuple[int, str]:
    result = CliRunner().invoke(main.app, ["tell", str(sensor.config), *words])
    return result.exit_code, result.output


def depth(rig: Post, topic: str, metres: float, time_ns: int) -> None:
    """Told for long enough to be believed at this time."""
    rig.send([(topic, Sample(time_ns=time_ns - back * NS, value=metres)) for back in (3, 2, 1, 0)])


def answers(session: Session) -> list[bytes]:
    """All estimates, to the bit."""
    return [record.message.SerializeToString() for record in session.messages((BIT_ESTIMATE,))]


def commands(session: Session) -> list[Event]:
    events = [cast("Event", record.message) for record in session.messages((SENSOR_EVENT,))]
    return [event for event in events if event.name == COMMAND]


def test_commands_and_depths_reach_the_ticks_and_a_session_of_them_is_exact(tmp_path: Path) -> None:
    with daemon(SHORT, free_bus(), tmp_path) as sensor:
        with post(sensor) as rig:
            begun_ns = time.time_ns()
            good = samples(simulated(8), begun_ns)
            rig.send(good[: 4 * RATE])
            assert say(sensor, "off", "bottom") == (0, "the bit is held to be off bottom\n")
            assert say(sensor, "longer", "30 m") == (0, f"the string is now {LENGTH + 30:.1f} m long\n")
            failed, told = say(sensor, "sideways")
            assert failed == 1
            assert "'sideways' is no command: say" in told
            rig.send(good[4 * RATE : 8 * RATE])
            wait_until(lambda: ("string_changed", True) in rig.events, "word of the longer string")
            assert say(sensor, "by", "depths")[0] == 0
            depth(rig, SURFACE_BIT_DEPTH, LENGTH + 28, begun_ns + 4 * NS)
            depth(rig, SURFACE_HOLE_DEPTH, LENGTH + 28, begun_ns + 4 * NS)
            rig.send(good[8 * RATE : 12 * RATE])
            wait_until(lambda: ("off_bottom", False) in rig.events, "word that the bit is on bottom")
            depth(rig, SURFACE_BIT_DEPTH, LENGTH + 25, begun_ns + 6 * NS)
            rig.send(good[12 * RATE :])
            wait_until(lambda: rig.events.count(("off_bottom", True)) == 2, "word of the lifted bit")
            status = rig.await_status(lambda told: told.off_bottom, "a status off bottom")
            assert status.string_length_m == LENGTH + 30
            heard = cast("list[Event]", rig.heard(SENSOR_EVENT))
            assert [e.text for e in heard if e.name == "string_changed"] == ["the string is 30.0 m longer"]
        sensor.end()
        (path,) = sensor.sessions
    session = Session(path)
    ticks = [cast("Tick", record.message) for record in session.messages((SENSOR_TICK,))]
    assert sum(tick.longer_by_m for tick in ticks) == 30
    assert {tick.off_bottom for tick in ticks} == {True, False}
    assert verify(session, Engine(loads(session.configuration or "", str(path)))).exact
    assert ticks[-1].time_ns - ticks[0].time_ns > 7 * NS
    assert [event.text for event in commands(session)] == ["off bottom", "longer 30 m", "by depths"]

    again = tmp_path / "again.mcap"
    result = CliRunner().invoke(main.app, ["estimate", str(path), "-o", str(again)])
    assert result.exit_code == 0, result.output
    assert answers(Session(again)) == answers(session)
    assert [event.text for event in commands(Session(again))] == ["off bottom", "longer 30 m", "by depths"]


def test_where_no_sensor_is_up_it_says_so(tmp_path: Path) -> None:
    config = tmp_path / "rig.toml"
    nobody = SHORT.model_copy(update={"bus": Bus(listen=("tcp/127.0.0.1:1",))})
    config.write_text(effective_toml(nobody))
    result = CliRunner().invoke(main.app, ["tell", str(config), "on", "bottom"])
    assert result.exit_code == 1
    assert "no bus at tcp/127.0.0.1:1" in result.output
