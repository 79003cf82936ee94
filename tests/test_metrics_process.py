"""A daemon that serves metrics, as processes: probes follow it, and it outlives them."""

import http.client
import os
import signal
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.daemons import Daemon, daemon, free_bus, post, wait_until
from tests.rigs import RATE, SHORT, samples, simulated
from vsensor.config import Bus, Metrics

pytestmark = pytest.mark.process


@pytest.fixture
def sensor(bus: Bus, tmp_path: Path) -> Iterator[Daemon]:
    port = int(free_bus().listen[0].rpartition(":")[2])
    rig = SHORT.model_copy(update={"metrics": Metrics(enabled=True, port=port)})
    with daemon(rig, bus, tmp_path) as started:
        yield started


def ask(sensor: Daemon, path: str) -> tuple[int, str]:
    """Status and text; 0 and nothing where nobody answers, or dies within the answer."""
    try:
        url = f"http://127.0.0.1:{sensor.rig.metrics.port}{path}"
        with urllib.request.urlopen(url, timeout=10) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()
    except (OSError, http.client.HTTPException):
        return 0, ""


def exporter(sensor: Daemon) -> int:
    """The process of the metrics, among the daemon's children."""
    pid = sensor.process.pid
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()
    (found,) = (child for child in children if b"metrics" in Path(f"/proc/{child}/cmdline").read_bytes())
    return int(found)


def test_probes_follow_the_daemon_and_it_outlives_them(sensor: Daemon) -> None:
    wait_until(lambda: ask(sensor, "/readyz") == (503, "waiting for samples\n"), "a daemon that waits")
    assert ask(sensor, "/livez")[0] == 200
    with post(sensor) as rig:
        rig.send(samples(simulated(4), time.time_ns()))
        rig.await_status(lambda status: status.ticks >= 4 * RATE - 5, "ticks")
        wait_until(lambda: 'vsensor_ticks_total{rig="test"}' in ask(sensor, "/metrics")[1], "its ticks")

        os.kill(sensor.process.pid, signal.SIGSTOP)
        wait_until(lambda: ask(sensor, "/livez") == (503, "the loop does not turn\n"), "a loop that stands")
        os.kill(sensor.process.pid, signal.SIGCONT)
        wait_until(lambda: ask(sensor, "/livez")[0] == 200, "a loop that turns")

        os.kill(exporter(sensor), signal.SIGKILL)
        before = rig.await_status(lambda status: status.slots_run > 0, "a status")
        rig.await_status(lambda status: status.slots_run > before.slots_run + RATE, "turns after its death")
        sensor.await_saying("the process that serves them ended (exit status -9)")
        wait_until(lambda: ask(sensor, "/livez")[0] == 200, "life again")
        sensor.await_saying("metrics are served again")
        assert 'vsensor_ticks_total{rig="test"}' in ask(sensor, "/metrics")[1]
    assert sensor.end() == 0


def test_its_process_ends_with_the_daemon_however_that_ends(sensor: Daemon) -> None:
    wait_until(lambda: ask(sensor, "/livez")[0] == 200, "life")
    sensor.process.kill()
    wait_until(lambda: ask(sensor, "/livez") == (0, ""), "its end")
