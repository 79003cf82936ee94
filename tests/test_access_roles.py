"""Who may do what: roles by certificate, by user, and on a router of its own, each over real sessions."""

import json
import time
from collections.abc import Iterator

import pytest
import zenoh

from tests.daemons import wait_until
from tests.locks import USERS, Etc, Party
from vsensor.bus import Feed, Questions, command, open_session, wait_for_sensor
from vsensor.config import Bus
from vsensor.errors import BusError
from vsensor.messages import (
    BIT_ESTIMATE,
    BIT_SPEED,
    SENSOR_ALIVE,
    SENSOR_COMMAND,
    SENSOR_EVENT,
    SENSOR_STATUS,
    STRING_PROFILE,
    SURFACE_BIT_DEPTH,
    SURFACE_TOPICS,
    SURFACE_TORQUE,
    Estimate,
    Status,
)

RIG = "rigs/well-b"
ROLES = ("surface", "viewer", "driller")
OURS = (BIT_SPEED, BIT_ESTIMATE, STRING_PROFILE, SENSOR_STATUS, SENSOR_EVENT)
END = "rigs/well-b/surface/end"


@pytest.fixture(scope="module")
def etc(tmp_path_factory: pytest.TempPathFactory) -> Etc:
    return Etc(tmp_path_factory.mktemp("etc"))


@pytest.fixture(scope="module", params=["daemon-mutual-tls", "daemon-password"])
def party(request: pytest.FixtureRequest, etc: Etc) -> Iterator[Party]:
    lock: str = request.param
    bus = etc.bus(lock)
    prove = etc.certified if lock == "daemon-mutual-tls" else etc.logged_in
    with Party(bus, {role: prove(bus, role) for role in ROLES}) as party:
        yield party


def heard(
    at: zenoh.Session, puts: dict[str, zenoh.Session], by: zenoh.Session, end: str = END
) -> dict[str, str]:
    """What arrives of these puts, each a key and who puts on it; `by` may publish and marks the `end`."""
    with at.declare_subscriber("rigs/**", zenoh.handlers.RingChannel(1000)) as subscriber:
        got: dict[str, str] = {}

        def take() -> bool:
            while (sample := subscriber.try_recv()) is not None:
                got[str(sample.key_expr)] = sample.payload.to_string()
            return end in got

        def is_subscribed() -> bool:
            by.put(end, "")
            return take()

        wait_until(is_subscribed, "a subscription")
        for session in {*puts.values()}:
            for key, who in puts.items():
                if who is session:
                    session.put(key, "x")
        time.sleep(0.3)  # what is refused leaves no trace to wait for
        got.pop(end)
        wait_until(is_subscribed, "the end")
        got.pop(end)
        return got


def test_the_surface_publishes_its_own_keys_and_nothing_else(party: Party) -> None:
    surface = party.clients["surface"]
    own = {f"{RIG}/{topic}": surface for topic in SURFACE_TOPICS}
    others = {f"{RIG}/{topic}": surface for topic in OURS} | {"rigs/well-b": surface, "other/key": surface}
    assert heard(party.daemon, own | others, by=surface).keys() == own.keys()


@pytest.mark.parametrize("role", ["viewer", "driller"])
def test_who_reads_publishes_nothing(party: Party, role: str) -> None:
    who = party.clients[role]
    puts = {f"{RIG}/{topic}": who for topic in (*SURFACE_TOPICS, *OURS)}
    assert heard(party.daemon, puts, by=party.clients["surface"]) == {}


@pytest.mark.parametrize("role", ROLES)
def test_all_may_read(party: Party, role: str) -> None:
    feed = Feed(party.clients[role], RIG)
    told: list[str] = []

    def hears() -> bool:
        party.daemon.put(
            f"{RIG}/{BIT_ESTIMATE}", Estimate(number=7).SerializeToString(), encoding="application/protobuf"
        )
        told.extend(topic for topic, _ in feed.drain())
        return bool(told)

    wait_until(hears, "an estimate")
    assert set(told) == {BIT_ESTIMATE}
    with party.daemon.liveliness().declare_token(f"{RIG}/{SENSOR_ALIVE}"):
        assert wait_for_sensor(party.clients[role], RIG)


@pytest.mark.parametrize("role", ROLES)
def test_all_may_ask_how_it_is_and_the_driller_alone_may_tell_it_something(party: Party, role: str) -> None:
    client = party.clients[role]
    commands = Questions(party.daemon, f"{RIG}/{SENSOR_COMMAND}")
    heard: list[str] = []

    def answer(query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, Status(rig="well-b").SerializeToString())

    def obey(words: str) -> str:
        heard.append(words)
        return "done"

    with party.daemon.declare_queryable(f"{RIG}/{SENSOR_STATUS}", answer):
        wait_until(
            lambda: any(reply.ok for reply in client.get(f"{RIG}/{SENSOR_STATUS}", timeout=5)), "a status"
        )
    told = client.get(f"{RIG}/{SENSOR_COMMAND}", payload="off bottom", timeout=1.0)

    def obeyed() -> bool:
        commands.answer(obey)
        return bool(heard) or role != "driller"

    wait_until(obeyed, "the command")
    replies = [reply for reply in told if reply.ok is not None]
    commands.answer(obey)
    assert (heard, len(replies)) == ((["off bottom"], 1) if role == "driller" else ([], 0))


def refuse(words: str) -> str:
    raise AssertionError(f"it was told {words}")


def test_a_viewer_that_tells_the_sensor_something_is_told_that_nobody_listens(party: Party) -> None:
    commands = Questions(party.daemon, f"{RIG}/{SENSOR_COMMAND}")
    with pytest.raises(BusError, match="no sensor answers"):
        command(party.clients["viewer"], RIG, "off bottom")
    commands.answer(refuse)


def test_the_roles_promise_the_same_however_they_are_proved(etc: Etc) -> None:
    control = {
        lock: json.loads(zenoh.Config.from_file(etc.zenoh(lock)).get_json("access_control"))
        for lock in ("daemon-mutual-tls", "daemon-password", "router")
    }
    certified, password, router = control.values()
    assert certified["default_permission"] == password["default_permission"] == "deny"
    assert certified["rules"] == password["rules"]
    assert certified["policies"] == password["policies"]
    assert [rule for rule in router["rules"] if "sensor" not in rule["id"]] == certified["rules"]
    assert [policy for policy in router["policies"] if policy["subjects"] != ["sensor"]] == certified[
        "policies"
    ]
    for by, lock in (("cert_common_names", certified), ("usernames", password)):
        assert {subject["id"]: subject[by] for subject in lock["subjects"]} == {
            role: [role] for role in USERS
        }


@pytest.fixture(scope="module")
def router(etc: Etc, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bus]:
    """The router of the example, on a free port: the bus as its clients see it."""
    bus = etc.bus("router")
    config = zenoh.Config.from_file(etc.zenoh("router"))
    config.insert_json5("listen/endpoints", json.dumps(bus.listen))
    with zenoh.open(config):
        yield Bus(listen=("tcp/127.0.0.1:0",), connect=bus.listen, zenoh_config=etc.zenoh("sensor"))


def test_on_a_router_the_sensor_publishes_its_own_keys_and_nothing_else(etc: Etc, router: Bus) -> None:
    with (
        open_session(router, "daemon") as sensor,
        open_session(etc.certified(router, "viewer"), "client") as viewer,
        open_session(etc.certified(router, "surface"), "client") as surface,
    ):
        own = {f"{RIG}/{topic}": sensor for topic in OURS}
        others = {f"{RIG}/{topic}": sensor for topic in (SURFACE_TORQUE, SURFACE_BIT_DEPTH)}
        assert heard(viewer, own | others, by=sensor, end=f"{RIG}/sensor/end").keys() == own.keys()
        rigs = {f"{RIG}/{topic}": surface for topic in SURFACE_TOPICS}
        assert heard(sensor, rigs | {f"{RIG}/{BIT_SPEED}": surface}, by=surface).keys() == rigs.keys()
        with sensor.liveliness().declare_token(f"{RIG}/{SENSOR_ALIVE}"):
            assert wait_for_sensor(viewer, RIG)


def test_what_an_advanced_publisher_keeps_reaches_who_comes_late(party: Party) -> None:
    """Its cache lies under a key that ** does not reach: the rules name it."""
    key = f"{RIG}/{SURFACE_TORQUE}"
    publisher = zenoh.ext.declare_advanced_publisher(
        party.clients["surface"], key, cache=zenoh.ext.CacheConfig(max_samples=10), publisher_detection=True
    )
    for number in range(3):
        publisher.put(str(number))
    late = zenoh.ext.declare_advanced_subscriber(
        party.daemon,
        key,
        zenoh.handlers.RingChannel(10),
        history=zenoh.ext.HistoryConfig(detect_late_publishers=True),
    )
    got: list[str] = []

    def all_came() -> bool:
        while (sample := late.try_recv()) is not None:
            got.append(sample.payload.to_string())
        return len(got) == 3

    wait_until(all_came, "what was published before")
    assert got == ["0", "1", "2"]
