"""A link that is cut: what was sent meanwhile comes afterwards, and what the cache has lost is counted."""

import time
from collections.abc import Iterator

import pytest
import zenoh

from tests.daemons import free_bus, wait_until
from tests.ends import CHANNELS
from tests.link import Link, link
from vsensor.bus import Outbox, SurfaceInbox, open_session, queue, recovering
from vsensor.config import Bus
from vsensor.messages import BIT_ESTIMATE, Estimate, Sample

pytestmark = pytest.mark.process

PREFIX = "rigs/cut"


@pytest.fixture
def bus() -> Bus:
    return free_bus()


@pytest.fixture
def daemon(bus: Bus) -> Iterator[zenoh.Session]:
    with open_session(bus, "daemon") as session:
        yield session


@pytest.fixture
def wire(bus: Bus, daemon: zenoh.Session) -> Iterator[Link]:
    with link(bus) as made:
        yield made


def send(outbox: Outbox, numbers: range, pause_s: float = 0.0) -> None:
    for number in numbers:
        for topic in CHANNELS:
            outbox.put(topic, Sample(time_ns=number, value=1.0, sequence=number))
        time.sleep(pause_s)


class Heard:
    """The sequence numbers that came, by channel."""

    def __init__(self, inbox: SurfaceInbox) -> None:
        self.inbox = inbox
        self.numbers: dict[str, list[int]] = {topic: [] for topic in CHANNELS}

    def up_to(self, number: int) -> bool:
        for received in self.inbox.drain():
            if received.sample is not None:
                self.numbers[received.topic].append(received.sample.sequence)
        return all(numbers and numbers[-1] == number for numbers in self.numbers.values())


def send_over_a_cut(wire: Link, heard: Heard, cache: int, pause_s: float) -> None:
    """650 samples of each channel, those from 200 to 599 while the link is cut, and wait for the last."""
    with open_session(wire.bus, "client") as client:
        outbox = Outbox(client, PREFIX, reliable=True, cache=cache)
        send(outbox, range(200), 0.001)
        wait_until(lambda: heard.up_to(199), "the first samples")
        wire.cut()
        time.sleep(0.2)  # that it is cut before the next is sent
        send(outbox, range(200, 600), pause_s)
        wire.mend()
        wait_until(lambda: heard.up_to(599), "the last of the cut")
        send(outbox, range(600, 650), 0.001)
        wait_until(lambda: heard.up_to(649), "those behind it")


def test_what_was_sent_while_the_link_was_cut_comes_in_its_order(
    daemon: zenoh.Session, wire: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However long the cut: what a start takes of before is no bound."""
    monkeypatch.setattr(queue, "HISTORY_S", 0.5)
    heard = Heard(SurfaceInbox(daemon, PREFIX, CHANNELS))
    send_over_a_cut(wire, heard, cache=2000, pause_s=0.005)  # for two seconds
    assert heard.numbers == {topic: list(range(650)) for topic in CHANNELS}
    assert heard.inbox.missed == 0


def test_what_the_cache_no_longer_has_is_counted(daemon: zenoh.Session, wire: Link) -> None:
    heard = Heard(SurfaceInbox(daemon, PREFIX, CHANNELS))
    send_over_a_cut(wire, heard, cache=50, pause_s=0.0005)
    for numbers in heard.numbers.values():
        assert numbers == sorted(set(numbers))
        assert set(range(550, 650)) <= set(numbers)
    came = sum(map(len, heard.numbers.values()))
    assert came < 2 * 650
    assert came + heard.inbox.missed == 2 * 650


def test_a_sensor_that_starts_later_hears_the_last_samples(bus: Bus, daemon: zenoh.Session) -> None:
    """So that one that was started again need not warm up."""
    with open_session(bus, "client") as client:
        outbox = Outbox(client, PREFIX, reliable=True)
        send(outbox, range(100))
        heard = Heard(SurfaceInbox(daemon, PREFIX, CHANNELS))
        wait_until(lambda: heard.up_to(99), "samples of before")
        assert heard.numbers == {topic: list(range(100)) for topic in CHANNELS}


def test_the_router_ends_and_another_takes_its_place(bus: Bus) -> None:
    """The rig goes on sending meanwhile."""
    with open_session(bus, "daemon") as first, open_session(bus, "client") as client:
        outbox = Outbox(client, PREFIX, reliable=True)
        heard = Heard(SurfaceInbox(first, PREFIX, CHANNELS))
        send(outbox, range(100), 0.001)
        wait_until(lambda: heard.up_to(99), "samples")
        first.close()  # type: ignore[no-untyped-call]
        send(outbox, range(100, 300), 0.005)
        with open_session(bus, "daemon") as second:
            heard = Heard(SurfaceInbox(second, PREFIX, CHANNELS))
            wait_until(lambda: heard.up_to(299), "samples of between")
            send(outbox, range(300, 350), 0.001)
            wait_until(lambda: heard.up_to(349), "samples of after")
    assert heard.numbers == {topic: list(range(350)) for topic in CHANNELS}


def test_whoever_listens_to_the_sensor_gets_back_what_a_cut_held_back(
    daemon: zenoh.Session, wire: Link
) -> None:
    outbox = Outbox(daemon, PREFIX, reliable=False)
    with open_session(wire.bus, "client") as client:
        subscriber = recovering(client, f"{PREFIX}/{BIT_ESTIMATE}", 10_000)
        numbers: list[int] = []

        def up_to(number: int) -> bool:
            while (raw := subscriber.try_recv()) is not None:
                numbers.append(Estimate.FromString(raw.payload.to_bytes()).number)
            return bool(numbers) and numbers[-1] == number

        outbox.put(BIT_ESTIMATE, Estimate(number=0))
        wait_until(lambda: up_to(0), "the first")
        wire.cut()
        for number in range(1, 200):
            outbox.put(BIT_ESTIMATE, Estimate(number=number))
            time.sleep(0.005)
        wire.mend()
        wait_until(lambda: up_to(199), "the last")
    assert numbers == list(range(200))
