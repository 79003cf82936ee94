"""Metrics: what a status comes to, the probes over real HTTP, rules and dashboard that name what is there."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families

from tests.daemons import wait_until
from tests.strings import PIPE, rig
from vsensor.config import Metrics
from vsensor.intake import Intake
from vsensor.messages import SURFACE_TORQUE, ChannelStatus, Sample, Status
from vsensor.messages.vsensor_pb2 import Histogram, Skill
from vsensor.metrics import exporter as exporter_module
from vsensor.metrics.exporter import Exporter, MetricsError
from vsensor.metrics.families import COUNTERS, GAUGES, HISTOGRAMS, families

CONFIG = Path(__file__).parent.parent / "config"
DOC = Path(__file__).parent.parent / "docs" / "metrics.md"
FULL = Status(
    rig="a",
    state="running",
    version="1",
    channels=[ChannelStatus(channel="surface/torque", accepted=5, late=2, lost=1, age_s=0.1)],
    skill=[Skill(ahead_s=0.5, speed_rms_rad_s=0.2)],
)
for _field in (*COUNTERS, *GAUGES):
    setattr(FULL, _field, 1)
for _field in HISTOGRAMS:
    upper = [2.0**k for k in range(9)]
    getattr(FULL, _field).CopyFrom(Histogram(upper_s=upper, counts=[1] * 10, sum_s=7.0))


@pytest.fixture
def metrics() -> Metrics:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return Metrics(enabled=True, port=probe.getsockname()[1])


@pytest.fixture
def exporter(metrics: Metrics) -> Iterator[Exporter]:
    with Exporter(metrics) as started:
        yield started


def get(metrics: Metrics, path: str) -> tuple[int, str]:
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{metrics.port}{path}", timeout=10) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def samples(text: str) -> dict[str, float]:
    told = (sample for family in text_string_to_metric_families(text) for sample in family.samples)
    return {f"{sample.name}{{{_labels(sample.labels)}}}": sample.value for sample in told}


def _labels(labels: dict[str, str]) -> str:
    return ",".join(f"{key}={labels[key]}" for key in sorted(labels))


def names() -> set[str]:
    """Every name that a query may ask for."""
    return {sample.name for family in families(FULL) for sample in family.samples}


def test_a_status_is_served_as_metrics_and_its_state_as_probes(metrics: Metrics, exporter: Exporter) -> None:
    assert get(metrics, "/metrics") == (200, "")
    assert get(metrics, "/livez") == (200, "starting\n")
    assert get(metrics, "/readyz") == (503, "starting\n")
    assert exporter.tell(FULL)
    wait_until(lambda: get(metrics, "/readyz") == (200, "running\n"), "readiness")
    told = samples(get(metrics, "/metrics")[1])
    assert told["vsensor_state{rig=a,state=running}"] == 1
    assert told["vsensor_state{rig=a,state=input lost}"] == 0
    assert told["vsensor_samples_total{channel=surface/torque,outcome=accepted,rig=a}"] == 5
    assert told["vsensor_samples_total{channel=surface/torque,outcome=late,rig=a}"] == 2
    assert told["vsensor_samples_lost{channel=surface/torque,rig=a}"] == 1
    assert exporter.tell(Status(rig="a", state="input lost"))
    wait_until(lambda: get(metrics, "/readyz") == (503, "input lost\n"), "unreadiness")
    assert get(metrics, "/livez")[0] == 200
    assert get(metrics, "/")[0] == 404


def test_histograms_are_cumulative_and_hold_every_turn() -> None:
    told = samples("".join(_exposed()))
    assert told["vsensor_work_seconds_bucket{le=1.0,rig=a}"] == 1
    assert told["vsensor_work_seconds_bucket{le=16.0,rig=a}"] == 5
    assert (
        told["vsensor_work_seconds_bucket{le=+Inf,rig=a}"] == told["vsensor_work_seconds_count{rig=a}"] == 10
    )
    assert told["vsensor_work_seconds_sum{rig=a}"] == 7


def _exposed() -> Iterator[str]:
    from prometheus_client import CollectorRegistry, generate_latest
    from prometheus_client.core import Metric
    from prometheus_client.registry import Collector

    class Once(Collector):
        def collect(self) -> Iterator[Metric]:
            return families(FULL)

    registry = CollectorRegistry()
    registry.register(Once())
    yield generate_latest(registry).decode()


def test_no_counter_goes_down_where_a_sample_that_was_missed_comes_late() -> None:
    """To Prometheus a counter that falls has begun anew, and all that it says is counted again."""
    intake, told = Intake(rig(PIPE)), []
    for sequence in (0, 1, 3, 2, 4):
        intake.take(SURFACE_TORQUE, Sample(time_ns=sequence, value=1.0, sequence=sequence))
        status = Status(rig="a", state="running", channels=[c.counts for c in intake.channels.values()])
        told.append(
            {
                f"{sample.name}{{{_labels(sample.labels)}}}": sample.value
                for family in families(status)
                if family.type == "counter"
                for sample in family.samples
            }
        )
    assert [counts.lost for counts in status.channels] == [0, 0]
    assert told[0]
    for before, after in pairwise(told):
        assert all(after[name] >= value for name, value in before.items())


def test_what_is_learned_and_not_saved_is_told() -> None:
    def told(status: Status) -> dict[str, float]:
        return {sample.name: sample.value for family in families(status) for sample in family.samples}

    trouble = Status(rig="a", learned_trouble="no such folder", bus_missed=3)
    assert told(Status(rig="a"))["vsensor_learned_unsaved"] == 0
    assert told(trouble)["vsensor_learned_unsaved"] == 1
    assert told(trouble)["vsensor_bus_missed_samples_total"] == 3


def test_what_a_status_does_not_tell_is_no_metric() -> None:
    told = {
        sample.name for family in families(Status(rig="a", state="starting")) for sample in family.samples
    }
    assert "vsensor_severity_ratio" not in told
    assert not any("_bucket" in name for name in told)


def test_a_loop_that_does_not_turn_has_no_metrics_and_does_not_live(
    metrics: Metrics, exporter: Exporter
) -> None:
    """The first five seconds after the last status are forgiven."""
    assert exporter.tell(FULL)
    wait_until(lambda: get(metrics, "/livez") == (200, "running\n"), "life")
    wait_until(lambda: get(metrics, "/livez") == (503, "the loop does not turn\n"), "silence")
    assert get(metrics, "/metrics") == (200, "")
    assert get(metrics, "/readyz")[0] == 503


def test_the_daemon_does_not_wait_for_a_process_that_is_stopped_or_dead(exporter: Exporter) -> None:
    os.kill(exporter.pid, signal.SIGSTOP)
    wait_until(lambda: not exporter.tell(FULL), "a full buffer")
    os.kill(exporter.pid, signal.SIGKILL)
    wait_until(lambda: not exporter.tell(FULL), "a broken pipe")


def test_a_process_that_died_is_told_and_started_again(metrics: Metrics, exporter: Exporter) -> None:
    died = exporter.pid
    os.kill(died, signal.SIGKILL)
    wait_until(lambda: not exporter.tell(FULL) and bool(exporter.trouble), "word of its death")
    assert exporter.trouble == (
        f"metrics at 127.0.0.1:{metrics.port}: the process that serves them ended (exit status -9)"
    )
    assert not Path(f"/proc/{died}").exists(), "it is nobody's zombie"
    wait_until(lambda: exporter.tell(FULL), "another")
    wait_until(lambda: get(metrics, "/readyz") == (200, "running\n"), "its answer")
    assert exporter.trouble == ""


def test_while_it_cannot_be_started_again_it_is_said_why_and_tried_ever_less_often(
    metrics: Metrics, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = []

    def refuse(_: Metrics) -> None:
        tried.append(time.monotonic())
        raise MetricsError("another has the port")

    monkeypatch.setattr(exporter_module, "AGAIN_S", 0.05)
    with Exporter(metrics) as exporter:
        monkeypatch.setattr(exporter_module, "_start", refuse)
        os.kill(exporter.pid, signal.SIGKILL)
        wait_until(lambda: not exporter.tell(FULL) and len(tried) == 5, "attempts")
        assert exporter.trouble == "another has the port"
    pauses = [later - earlier for earlier, later in pairwise(tried)]
    assert all(later > 1.5 * earlier for earlier, later in pairwise(pauses)), pauses


def test_a_port_that_is_taken_is_named(metrics: Metrics, exporter: Exporter) -> None:
    with pytest.raises(
        MetricsError, match=rf"metrics at 127\.0\.0\.1:{metrics.port}: cannot listen: Address"
    ):
        Exporter(metrics)


def test_it_listens_on_this_machine_alone(metrics: Metrics, exporter: Exporter) -> None:
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", metrics.port), timeout=5)


def queries() -> Iterator[str]:
    board = json.loads((CONFIG / "grafana" / "vsensor.json").read_text(encoding="utf-8"))
    for panel in board["panels"]:
        for target in panel.get("targets", ()):
            yield target["expr"]
    yield (CONFIG / "prometheus" / "alerts.yml").read_text(encoding="utf-8")


def test_dashboard_and_rules_ask_for_what_there_is() -> None:
    asked = {name for query in queries() for name in re.findall(r"\bvsensor_\w+", query)}
    assert len(asked) > 20
    assert asked <= names()


def test_the_list_of_metrics_is_complete() -> None:
    listed = set(re.findall(r"^\| `(vsensor_?\w*)", DOC.read_text(encoding="utf-8"), re.MULTILINE))
    there = {re.sub(r"_(bucket|count|sum|created)$", "", name) for name in names()}
    assert listed == there


@pytest.mark.skipif(shutil.which("promtool") is None, reason="promtool comes with Debian's prometheus")
def test_prometheus_itself_takes_the_rules_and_the_dashboards_queries(tmp_path: Path) -> None:
    board = [query.replace("$rig", ".*") for query in queries() if "groups:" not in query]
    rules = [{"record": f"query:{number}", "expr": query} for number, query in enumerate(board)]
    file = tmp_path / "board.yml"
    file.write_text(json.dumps({"groups": [{"name": "board", "rules": rules}]}), encoding="utf-8")
    alerts = CONFIG / "prometheus" / "alerts.test.yml"
    for words in (["check", "rules", str(file)], ["test", "rules", str(alerts)]):
        done = subprocess.run(["promtool", *words], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
