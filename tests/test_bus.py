"""Zenoh: samples in order and in any form, nothing of other rigs, errors that say what to do."""

import ctypes
import itertools
import json
import os
import resource
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh

from tests.daemons import free_bus, wait_until
from tests.ends import CHANNELS, received
from vsensor.bus import Feed, Outbox, SurfaceInbox, open_session, wait_for_sensor
from vsensor.config import Bus
from vsensor.errors import BusError, ConfigError
from vsensor.messages import (
    BIT_ESTIMATE,
    BIT_SPEED,
    SENSOR_ALIVE,
    SENSOR_STATUS,
    SENSOR_TICK,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Estimate,
    Message,
    Sample,
    surface,
)

NS = 1_000_000_000
PR_CAPBSET_DROP = 24
CAP_IPC_LOCK = 14
NUMBERS = itertools.count()


@pytest.fixture(scope="module")
def network() -> Bus:
    return free_bus()


@pytest.fixture(scope="module")
def daemon(network: Bus) -> Iterator[zenoh.Session]:
    with open_session(network, "daemon") as session:
        yield session


@pytest.fixture(scope="module")
def client(network: Bus, daemon: zenoh.Session) -> Iterator[zenoh.Session]:
    with open_session(network, "client") as session:
        yield session


@pytest.fixture
def prefix() -> str:
    """A rig of its own for each test."""
    return f"rigs/{next(NUMBERS)}"


def test_samples_of_both_channels_come_in_the_order_in_which_they_were_sent(
    daemon: zenoh.Session, client: zenoh.Session, prefix: str
) -> None:
    inbox = SurfaceInbox(daemon, prefix, CHANNELS)
    outbox = Outbox(client, prefix, reliable=True)
    sent = [(CHANNELS[k % 2], Sample(time_ns=k, value=k / 3, sequence=k // 2)) for k in range(4000)]
    before_ns = time.time_ns()
    for topic, sample in sent:
        outbox.put(topic, sample)

    got = received(inbox, len(sent))
    assert [(each.topic, each.sample) for each in got] == sent
    assert all(before_ns <= each.received_ns <= time.time_ns() for each in got)


def test_how_many_samples_waited_for_a_turn_is_known(
    daemon: zenoh.Session, client: zenoh.Session, prefix: str
) -> None:
    inbox = SurfaceInbox(daemon, prefix, CHANNELS)
    outbox = Outbox(client, prefix, reliable=True)
    outbox.put(CHANNELS[0], Sample(value=1.0))
    received(inbox, 1)
    assert inbox.most_waiting() == 1
    for number in range(50):
        outbox.put(CHANNELS[0], Sample(value=1.0, sequence=number))
    found: list[int] = []

    def drained() -> bool:
        found.append(sum(1 for _ in inbox.drain()))
        return sum(found) == 50

    wait_until(drained, "50 samples")
    assert inbox.most_waiting() == max(found)
    assert inbox.most_waiting() == 0


def test_what_was_put_is_returned_for_the_recorder(client: zenoh.Session, prefix: str) -> None:
    sample = Sample(time_ns=1, value=2.0)
    assert Outbox(client, prefix, reliable=False).put(SURFACE_SPEED, sample) == sample.SerializeToString()


@pytest.mark.parametrize("stamped", [True, False], ids=["stamped by its sender", "not stamped"])
def test_a_bare_number_has_the_time_of_the_bus(
    daemon: zenoh.Session, network: Bus, prefix: str, stamped: bool
) -> None:
    """Where the sender does not stamp what it sends, the daemon, which routes it, does."""
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps(network.listen))
    config.insert_json5("timestamping/enabled", json.dumps(stamped))
    inbox = SurfaceInbox(daemon, prefix, CHANNELS)
    with zenoh.open(config) as stranger:
        stranger.put(f"{prefix}/{SURFACE_TORQUE}", "1234.5", encoding="text/plain")
        (got,) = received(inbox, 1)
    assert got.sample is not None
    assert got.sample.value == 1234.5
    assert abs(got.sample.time_ns - got.received_ns) < 5 * NS


def test_json_is_read_by_its_stated_encoding(
    daemon: zenoh.Session, client: zenoh.Session, prefix: str
) -> None:
    inbox = SurfaceInbox(daemon, prefix, CHANNELS)
    client.put(
        f"{prefix}/{SURFACE_TORQUE}",
        '{"time_ns": "17", "value": 2.5, "sequence": 3}',
        encoding="application/json",
    )
    (got,) = received(inbox, 1)
    assert got.sample == Sample(time_ns=17, value=2.5, sequence=3)


@pytest.mark.parametrize(
    ("payload", "encoding"),
    [
        (b"", "application/protobuf"),
        (b"", "zenoh/bytes"),
        (b"\xff\xff", "application/protobuf"),
        (b"{", "application/json"),
        (b"heavy", "text/plain"),
        (bytes(3_000_000), "application/protobuf"),
        (b"1.0", "image/png"),
    ],
    ids=["empty", "empty, no encoding", "garbage", "half", "word", "huge", "a picture"],
)
def test_what_cannot_be_read_is_told_and_what_follows_is_read(
    daemon: zenoh.Session, client: zenoh.Session, prefix: str, payload: bytes, encoding: str
) -> None:
    inbox = SurfaceInbox(daemon, prefix, CHANNELS)
    whole = zenoh.CongestionControl.BLOCK  # megabytes: a busy machine would drop a piece
    client.put(f"{prefix}/{SURFACE_TORQUE}", payload, encoding=encoding, congestion_control=whole)
    client.put(f"{prefix}/{SURFACE_TORQUE}", "1", encoding="text/plain", congestion_control=whole)
    bad, good = received(inbox, 2)
    assert bad.topic == SURFACE_TORQUE
    assert bad.sample is None
    assert bad.unreadable is not None
    assert (bad.unreadable.channel, bad.unreadable.encoding) == (SURFACE_TORQUE, encoding)
    assert bad.unreadable.payload == (payload if len(payload) <= surface.MAX_BYTES else b"")
    assert bad.unreadable.fault
    assert good.sample is not None


def test_other_channels_and_other_rigs_are_not_heard(
    daemon: zenoh.Session, client: zenoh.Session, prefix: str
) -> None:
    inbox = SurfaceInbox(daemon, prefix, CHANNELS)
    for key in (f"{prefix}/surface/bit_depth", "rigs/other/surface/torque", f"{prefix}/surface/torque/x"):
        client.put(key, "1", encoding="text/plain")
    client.put(f"{prefix}/{SURFACE_TORQUE}", "2", encoding="text/plain")
    (got,) = received(inbox, 1)
    assert got.sample is not None
    assert got.sample.value == 2


def test_a_viewer_hears_what_it_knows_and_passes_over_the_rest(
    daemon: zenoh.Session, client: zenoh.Session, prefix: str
) -> None:
    feed = Feed(client, prefix)
    outbox = Outbox(daemon, prefix, reliable=True)
    heard: list[tuple[str, Message]] = []

    def hears(topic: str) -> bool:
        heard.extend(feed.drain())
        return any(told == topic for told, _ in heard)

    def is_subscribed() -> bool:
        outbox.put(SURFACE_TORQUE, Sample(time_ns=1, value=1.0))
        return hears(SURFACE_TORQUE)

    wait_until(is_subscribed, "the subscription")
    daemon.put(f"{prefix}/{BIT_ESTIMATE}", b"\xff\xff", encoding="application/protobuf")
    daemon.put(f"{prefix}/{BIT_ESTIMATE}", "1.0", encoding="text/plain")
    daemon.put(f"{prefix}/weather", b"", encoding="application/protobuf")
    estimate = Estimate(number=7, now_bit_speed_rad_s=0.0)
    outbox.put(BIT_ESTIMATE, estimate)

    wait_until(lambda: hears(BIT_ESTIMATE), "the estimate")
    assert [message for topic, message in heard if topic != SURFACE_TORQUE] == [estimate]


def test_what_others_wait_for_goes_out_at_once_and_the_rest_with_it(
    daemon: zenoh.Session, client: zenoh.Session, prefix: str
) -> None:
    heard: dict[str, bool] = {}
    with client.declare_subscriber(
        f"{prefix}/**", lambda raw: heard.update({str(raw.key_expr).removeprefix(f"{prefix}/"): raw.express})
    ):
        outbox = Outbox(daemon, prefix, reliable=True)

        def is_heard() -> bool:
            for topic in (SURFACE_TORQUE, SURFACE_SPEED, BIT_ESTIMATE, BIT_SPEED, SENSOR_TICK, SENSOR_STATUS):
                outbox.put(topic, Sample(time_ns=1, value=1.0))
            return len(heard) == 6

        wait_until(is_heard, "all topics")
    at_once = {topic for topic, express in heard.items() if express}
    assert at_once == {SURFACE_TORQUE, SURFACE_SPEED, BIT_ESTIMATE}


def test_a_sensor_is_waited_for_until_it_says_that_it_lives(
    daemon: zenoh.Session, client: zenoh.Session, prefix: str
) -> None:
    assert not wait_for_sensor(client, prefix, timeout_s=0.2)
    with daemon.liveliness().declare_token(f"{prefix}/{SENSOR_ALIVE}"):
        assert wait_for_sensor(client, prefix)
        assert not wait_for_sensor(client, "rigs/other", timeout_s=0.2)


def test_a_port_that_is_taken_is_named(network: Bus, daemon: zenoh.Session) -> None:
    with pytest.raises(BusError, match=rf"{network.listen[0]}: is the port taken\?"):
        open_session(network, "daemon")


def test_a_client_without_a_daemon_is_told_what_to_start(bus: Bus) -> None:
    with pytest.raises(BusError, match=rf"{bus.listen[0]}: is the daemon \(vsensor run\) up\?"):
        open_session(bus, "client")


@pytest.mark.parametrize(("text", "fault"), [(None, "No such file"), ("{mode: [", "expected")])
def test_zenohs_own_settings_that_cannot_be_read_are_a_fault_of_the_configuration(
    tmp_path: Path, bus: Bus, text: str | None, fault: str
) -> None:
    file = tmp_path / "zenoh.json5"
    if text is not None:
        file.write_text(text)
    with pytest.raises(ConfigError, match=rf"zenoh_config .*zenoh\.json5: .*(?s:.*){fault}") as error:
        open_session(bus.model_copy(update={"zenoh_config": file}), "daemon")
    assert ".rs" not in str(error.value)


def test_zenohs_own_settings_are_used_under_ours(tmp_path: Path, bus: Bus) -> None:
    file = tmp_path / "zenoh.json5"
    file.write_text('{id: "abcdef", mode: "client", listen: {endpoints: ["tcp/0.0.0.0:1"]}}')
    with open_session(bus.model_copy(update={"zenoh_config": file}), "daemon") as session:
        assert str(session.info.zid()) == "abcdef"
        with open_session(bus, "client"):
            pass


def test_it_needs_no_locked_memory(bus: Bus) -> None:
    """Containers, and old systems, grant hardly any."""
    code = """
import sys
from vsensor.bus import open_session
from vsensor.config import Bus
with open_session(Bus(listen=(sys.argv[1],)), "daemon"):
    print("open")
"""

    def without() -> None:
        resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))
        ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_IPC_LOCK, 0, 0, 0)  # root is refused nothing else

    done = subprocess.run(
        [sys.executable, "-c", code, bus.listen[0]],
        preexec_fn=without,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.stdout, done.stderr) == ("open\n", "")


THREADS = """
from pathlib import Path
from sys import argv
from vsensor.bus import open_session
from vsensor.config import Bus
with open_session(Bus(listen=(argv[1],)), "daemon"):
    print(*(name.read_text().strip() for name in Path("/proc/self/task").glob("*/comm")))
"""


@pytest.mark.process
@pytest.mark.parametrize(("told", "waits"), [("", False), ("(rx: (worker_threads: 1))", True)])
def test_no_thread_but_those_that_decode_waits_for_packets_unless_an_operator_says_so(
    bus: Bus, told: str, waits: bool
) -> None:
    told_so = {"ZENOH_RUNTIME": told} if told else {}
    kept = {name: value for name, value in os.environ.items() if name != "ZENOH_RUNTIME"}
    words = [sys.executable, "-c", THREADS, bus.listen[0]]
    done = subprocess.run(words, env={**kept, **told_so}, capture_output=True, text=True, check=True)
    assert "net-0" in done.stdout.split()
    assert ("acc-0" in done.stdout.split()) == waits


def test_the_daemon_listens_on_this_machine_alone(network: Bus, daemon: zenoh.Session) -> None:
    port = int(network.listen[0].rpartition(":")[2])
    with socket.create_connection(("127.0.0.1", port), timeout=5):
        pass
    with pytest.raises(OSError, match="refused"):
        # 127.0.0.2 is this machine too, by another address: one that a socket for all would answer.
        socket.create_connection(("127.0.0.2", port), timeout=5)
