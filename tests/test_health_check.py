"""What others ask a live daemon: the image's health check, and the dashboard's queries by a Prometheus."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import urllib.parse
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.daemons import Daemon, daemon, free_bus, post, wait_until
from tests.live import WARM_S, LiveRig
from tests.rigs import SHORT
from vsensor.bus import SURFACE_CACHE, Outbox, open_session
from vsensor.config import Bus, Metrics

pytestmark = pytest.mark.process

ROOT = Path(__file__).parent.parent
EMPTY = {'deriv(vsensor_samples_lost{rig=~".*"}[1m]) > 0'}
"""Queries that have no answer where nothing was lost."""


def free_port() -> int:
    return int(free_bus().listen[0].rpartition(":")[2])


@pytest.fixture
def sensor(bus: Bus, tmp_path: Path) -> Iterator[Daemon]:
    rig = SHORT.model_copy(update={"metrics": Metrics(enabled=True, port=free_port())})
    with daemon(rig, bus, tmp_path) as started:
        yield started


def is_healthy(sensor: Daemon) -> bool:
    """What the image's HEALTHCHECK finds, its own words run with this daemon's port."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    (words,) = re.findall(r"HEALTHCHECK .*\\\n\s+CMD (\[.*\])", text)
    program, *given = json.loads(words)
    assert program == "python"
    given = [each.replace(":9464/", f":{sensor.rig.metrics.port}/") for each in given]
    return subprocess.run([sys.executable, *given], stderr=subprocess.DEVNULL, check=False).returncode == 0


def test_the_images_health_check_tells_a_daemon_that_hangs_or_is_dead(sensor: Daemon) -> None:
    wait_until(lambda: is_healthy(sensor), "a healthy daemon")
    os.kill(sensor.process.pid, signal.SIGSTOP)
    wait_until(lambda: not is_healthy(sensor), "a daemon that hangs")
    os.kill(sensor.process.pid, signal.SIGCONT)
    wait_until(lambda: is_healthy(sensor), "a daemon that goes on")
    sensor.end(signal.SIGKILL)
    wait_until(lambda: not is_healthy(sensor), "a dead daemon")


def queries() -> Iterator[str]:
    """Each query of the dashboard, for all rigs."""
    board = json.loads((ROOT / "config" / "grafana" / "vsensor.json").read_text(encoding="utf-8"))
    for panel in board["panels"]:
        for target in panel.get("targets", ()):
            yield target["expr"].replace("$rig", ".*")


def answers(port: int, query: str) -> list[Any]:
    """What Prometheus finds; nothing while it does not answer."""
    url = f"http://127.0.0.1:{port}/api/v1/query?" + urllib.parse.urlencode({"query": query})
    try:
        with urllib.request.urlopen(url, timeout=10) as answer:
            found: list[Any] = json.load(answer)["data"]["result"]
            return found
    except OSError:
        return []


@pytest.mark.skipif(shutil.which("prometheus") is None, reason="there is no Prometheus here")
def test_each_query_of_the_dashboard_finds_something_of_a_live_daemon(sensor: Daemon, tmp_path: Path) -> None:
    text = (ROOT / "config" / "prometheus" / "prometheus.yml").read_text(encoding="utf-8")
    text = text.replace(":9464", f":{sensor.rig.metrics.port}").replace(
        "scrape_interval: 5s", "scrape_interval: 1s"
    )
    (tmp_path / "prometheus.yml").write_text(text, encoding="utf-8")
    shutil.copy(ROOT / "config" / "prometheus" / "alerts.yml", tmp_path)
    port = free_port()
    command = [
        "prometheus",
        f"--config.file={tmp_path / 'prometheus.yml'}",
        f"--storage.tsdb.path={tmp_path / 'data'}",
        f"--web.listen-address=127.0.0.1:{port}",
    ]
    with (
        subprocess.Popen(command, stderr=subprocess.DEVNULL) as prometheus,
        post(sensor) as near,
        open_session(sensor.rig.bus, "client") as session,
    ):
        try:
            rig = LiveRig(Outbox(session, SHORT.prefix, reliable=True, cache=SURFACE_CACHE))
            missing = {*queries()} - EMPTY
            while missing and rig.readings < 1800:
                rig.live(WARM_S / 2)
                near.send(rig.sent[:2])  # a sample of long ago, to be refused
                missing = {query for query in missing if not answers(port, query)}
            assert missing == set()
            for query in EMPTY:
                assert query in {*queries()}
                assert answers(port, query) == []
        finally:
            prometheus.terminate()
