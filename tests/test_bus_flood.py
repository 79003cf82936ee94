"""A flood on the bus: bounded, refused, counted, and no other channel's loss."""

from collections.abc import Iterator

import pytest

from tests.ends import CHANNELS, Ends, ends, received, times_ns
from vsensor.bus import Received
from vsensor.messages import SURFACE_BIT_DEPTH, SURFACE_SPEED, SURFACE_TORQUE


@pytest.fixture(scope="module")
def sessions() -> Iterator[Ends]:
    with ends() as made:
        yield made


@pytest.fixture
def rig(sessions: Ends) -> Ends:
    """A rig of its own for each test."""
    return Ends(sessions.daemon, sessions.client)


@pytest.mark.parametrize("flooded", [SURFACE_TORQUE, SURFACE_BIT_DEPTH, "surface/unheard_of"])
def test_a_flood_on_one_key_pushes_out_no_sample_of_another(rig: Ends, flooded: str) -> None:
    inbox = rig.inbox((*CHANNELS, SURFACE_BIT_DEPTH), capacity=20)
    rig.send(SURFACE_SPEED, range(5))
    rig.send(flooded, range(1000))
    assert times_ns(list(inbox.drain(hold=False)), SURFACE_SPEED) == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("turns", range(6))
def test_what_a_drain_has_no_time_for_comes_once_and_in_its_place(rig: Ends, turns: int) -> None:
    inbox = rig.inbox()
    for topic in CHANNELS:
        rig.send(topic, range(3))
    time_left = iter([True] * turns + [False])
    got = list(inbox.drain(lambda: next(time_left), hold=False))
    assert len(got) == turns
    rig.send(SURFACE_SPEED, [3])
    got += inbox.drain(hold=False)
    assert times_ns(got, SURFACE_TORQUE) == [0, 1, 2]
    assert times_ns(got, SURFACE_SPEED) == [0, 1, 2, 3]


def test_time_is_asked_for_only_where_something_waits(rig: Ends) -> None:
    inbox = rig.inbox((SURFACE_SPEED,))
    rig.send(SURFACE_SPEED, range(3))
    asked: list[bool] = []

    def more() -> bool:
        asked.append(True)
        return True

    assert len(list(inbox.drain(more, hold=False))) == len(asked) == 3
    assert list(inbox.drain(more, hold=False)) == []
    assert len(asked) == 3


def test_one_call_ends_however_fast_the_inbox_is_filled_meanwhile(rig: Ends) -> None:
    inbox = rig.inbox((SURFACE_SPEED,), capacity=10)
    rig.send(SURFACE_SPEED, range(10))
    got = 0
    for number, _ in enumerate(inbox.drain()):
        rig.send(SURFACE_SPEED, [10 + number])
        got += 1
    assert got == 10


def test_where_the_inbox_overflows_the_newest_samples_stay(rig: Ends) -> None:
    inbox = rig.inbox((SURFACE_SPEED,), capacity=10)
    rig.send(SURFACE_SPEED, range(25))
    assert times_ns(list(inbox.drain()), SURFACE_SPEED) == list(range(15, 25))


def test_samples_over_the_rate_are_refused_unread_and_each_is_told(rig: Ends) -> None:
    """Of each channel by itself: a flood on the one takes nothing from the other."""
    inbox = rig.inbox(max_rate=1e-3, capacity=100)
    rig.send(SURFACE_SPEED, [0])
    got: list[Received] = []
    for number in range(250):
        rig.send(SURFACE_TORQUE, [number])
        got.extend(inbox.drain())
    rig.send(SURFACE_SPEED, [250])
    got.extend(received(inbox, 252 - len(got)))
    torque = [each for each in got if each.topic == SURFACE_TORQUE]
    assert [each.over_rate for each in torque] == [False] * 100 + [True] * 150
    assert all(each.sample is None for each in torque[100:])
    assert times_ns(got, SURFACE_SPEED) == [0, 250]


def test_of_a_flood_no_more_is_refused_at_a_time_than_there_is_time_for(rig: Ends) -> None:
    """And the other channel has its turn in spite of it."""
    inbox = rig.inbox(max_rate=1e-3, most_refused=7, capacity=30)
    rig.send(SURFACE_SPEED, [0])
    rig.send(SURFACE_TORQUE, range(30))
    received(inbox, 31)
    rig.send(SURFACE_TORQUE, range(30))
    rig.send(SURFACE_SPEED, [1])
    first = list(inbox.drain())
    assert times_ns(first, SURFACE_SPEED) == [1]
    got = [len(first) - 1]
    while sum(got) < 30:
        got.append(len(list(inbox.drain())))
    assert max(got) == 7
