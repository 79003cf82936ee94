"""Listening on a real bus: that may come late, go, and come again."""

import socket
import time
from collections.abc import Callable

import pytest

from tests.view_rig import tick
from vsensor.bus import Outbox, open_session
from vsensor.config import Bus
from vsensor.messages import SENSOR_ALIVE, SENSOR_TICK, Message, Tick
from vsensor.view.ears import Ears
from vsensor.view.place import ViewError

PATIENCE_S = 20.0


@pytest.fixture
def bus() -> Bus:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return Bus(listen=(f"tcp/127.0.0.1:{probe.getsockname()[1]}",))


def until(question: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not question():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def heard(ears: Ears, put: Callable[[int], object]) -> Tick:
    """Publish until something is heard, and return the first that was."""
    found: list[Message] = []
    number = 0

    def try_once() -> bool:
        nonlocal number
        number += 1
        put(number)
        found.extend(ears.drain())
        return bool(found)

    until(try_once)
    assert isinstance(found[0], Tick)
    return found[0]


def test_it_waits_for_the_daemon_and_hears_it_again_after_a_restart(bus: Bus) -> None:
    said: list[str] = []
    with Ears(bus, "rigs/t", said.append) as ears:
        for _ in range(3):
            assert list(ears.drain()) == []
        assert len(said) == 1
        assert "is the daemon (vsensor run) up?" in said[0]
        for begun in (1000, 2000):
            with open_session(bus, "daemon") as daemon:
                outbox = Outbox(daemon, "rigs/t", reliable=False)
                assert heard(ears, lambda n: outbox.put(SENSOR_TICK, tick(begun + n))).number > begun  # noqa: B023
            list(ears.drain())
    assert said[1:] == ["listening to rigs/t"]


def test_without_a_name_it_finds_the_one_that_is_alive(bus: Bus) -> None:
    said: list[str] = []
    with open_session(bus, "daemon") as daemon, Ears(bus, None, said.append) as ears:
        list(ears.drain())
        assert said == ["no sensor is alive on the bus yet; waiting for one"]
        token = daemon.liveliness().declare_token(f"rigs/found/{SENSOR_ALIVE}")
        outbox = Outbox(daemon, "rigs/found", reliable=False)
        assert heard(ears, lambda n: outbox.put(SENSOR_TICK, tick(n)))
        token.undeclare()  # type: ignore[no-untyped-call]
    assert said[1:] == ["listening to rigs/found"]


def test_of_several_that_are_alive_one_must_be_named(bus: Bus) -> None:
    with open_session(bus, "daemon") as daemon, Ears(bus, None, lambda _: None) as ears:
        tokens = [daemon.liveliness().declare_token(f"rigs/{name}/{SENSOR_ALIVE}") for name in ("a", "b")]
        with pytest.raises(ViewError, match=r"rigs/a, rigs/b: name one by --rig"):
            until(lambda: bool(list(ears.drain())))
        for token in tokens:
            token.undeclare()  # type: ignore[no-untyped-call]
