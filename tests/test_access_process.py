"""A daemon behind a lock, as a process: it works as without, and tells no secret."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.daemons import Daemon, daemon, post
from tests.locks import USERS, Etc
from tests.rigs import RATE, SHORT, samples, simulated
from vsensor.config import Recording
from vsensor.messages import SENSOR_STATUS

pytestmark = pytest.mark.process

UNPACKED = SHORT.model_copy(update={"recording": Recording(compression="none")})


@pytest.fixture
def etc(tmp_path: Path) -> Etc:
    return Etc(tmp_path / "etc")


@pytest.fixture
def sensor(etc: Etc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Daemon]:
    monkeypatch.setenv("RUST_LOG", "trace")  # were Zenoh's log switched on by it, it would tell them
    bus = etc.logged_in(etc.bus("daemon-password"), "surface")
    with daemon(UNPACKED, bus, tmp_path) as started:
        yield started


def test_no_secret_is_in_status_log_or_session(sensor: Daemon, etc: Etc) -> None:
    with post(sensor) as rig:
        rig.send(samples(simulated(4), time.time_ns()))
        rig.await_status(lambda status: status.ticks >= 4 * RATE - 5, "ticks")
        (reply,) = rig.session.get(f"{rig.prefix}/{SENSOR_STATUS}", timeout=20.0)
        assert reply.ok is not None
        status = reply.ok.payload.to_bytes()
    assert sensor.end() == 0
    (session,) = sensor.sessions
    left = session.read_bytes()
    assert b"password_file" in left  # where the configuration stands, uncompressed
    keys = [key.read_text(encoding="ascii").split("\n")[1] for key in (etc.folder / "tls").glob("*.key")]
    for secret in (*USERS.values(), *keys):
        assert secret not in sensor.said
        assert secret.encode() not in left
        assert secret.encode() not in status


def test_a_stranger_is_refused_by_our_own_commands_without_a_secret(sensor: Daemon, etc: Etc) -> None:
    wrong = etc.secret("wrong.password", "sesame")
    config = sensor.config.with_name("stranger.toml")
    text = sensor.config.read_text(encoding="utf-8")
    config.write_text(text.replace(str(sensor.rig.bus.password_file), str(wrong)), encoding="utf-8")
    told = subprocess.run(
        [sys.executable, "-m", "vsensor.cli.main", "tell", str(config), "off", "bottom"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env=os.environ | {"COLUMNS": "200"},
    )
    assert told.returncode == 1
    assert "Does it take our certificate, our user and password?" in told.stderr
    assert "sesame" not in told.stderr + told.stdout
