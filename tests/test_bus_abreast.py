"""Torque and speed in step, whichever comes first: after a cut, after a start, and while one is silent."""

import time
from collections.abc import Iterator
from itertools import pairwise

import pytest

from tests.daemons import wait_until
from tests.ends import Ends, ends, received, times_ns
from vsensor.bus import Received, SurfaceInbox, queue
from vsensor.grid import NS
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE

MS = NS // 1000
SECONDS = range(0, 60 * NS, 100 * MS)
"""A minute at 10 Hz."""


@pytest.fixture(scope="module")
def sessions() -> Iterator[Ends]:
    with ends() as made:
        yield made


@pytest.fixture
def rig(sessions: Ends) -> Ends:
    return Ends(sessions.daemon, sessions.client)


def most_ahead_ns(got: list[Received]) -> int:
    """How far one channel was ever ahead of the other."""
    newest = dict.fromkeys((SURFACE_TORQUE, SURFACE_SPEED), 0)
    ahead = 0
    for each in got:
        assert each.sample is not None
        newest[each.topic] = each.sample.time_ns
        ahead = max(ahead, abs(newest[SURFACE_TORQUE] - newest[SURFACE_SPEED]))
    return ahead


def held(inbox: SurfaceInbox, seconds: float) -> list[Received]:
    """What is given out within a time; nothing, it is hoped."""
    end = time.monotonic() + seconds
    got: list[Received] = []
    while time.monotonic() < end:
        got.extend(inbox.drain())
    return got


def test_a_backlog_of_both_is_given_out_in_step(rig: Ends) -> None:
    inbox = rig.inbox()
    rig.send(SURFACE_TORQUE, SECONDS)
    rig.send(SURFACE_SPEED, SECONDS)
    got = list(inbox.drain())
    assert len(got) == 2 * len(SECONDS)
    assert most_ahead_ns(got) == 100 * MS


def test_where_the_one_backlog_comes_first_it_waits_for_the_other(rig: Ends) -> None:
    inbox = rig.inbox()
    rig.send(SURFACE_TORQUE, SECONDS)
    got = held(inbox, 0.1)
    assert got == []
    rig.send(SURFACE_SPEED, SECONDS[:100])
    got += inbox.drain()
    rig.send(SURFACE_SPEED, SECONDS[100:])
    got += received(inbox, 2 * len(SECONDS) - len(got))
    assert most_ahead_ns(got) <= 250 * MS + 100 * MS


def test_it_waits_again_after_each_silence_of_both(rig: Ends) -> None:
    inbox = rig.inbox()
    for part in (SECONDS[:10], SECONDS[10:]):
        rig.send(SURFACE_SPEED, part)
        assert len(held(inbox, 0.1)) < 10
        rig.send(SURFACE_TORQUE, part)
        received(inbox, len(part) + 1)
        time.sleep(queue.PATIENCE_NS / NS)  # the silence itself


def test_a_channel_alone_waits_for_a_moment_once_and_then_no_more(
    rig: Ends, monkeypatch: pytest.MonkeyPatch
) -> None:
    inbox = rig.inbox()
    begun = time.monotonic()
    rig.send(SURFACE_TORQUE, SECONDS[:1])
    received(inbox, 1)
    assert time.monotonic() - begun >= queue.PATIENCE_NS / NS
    now_ns = time.monotonic_ns()
    for before, after in pairwise(SECONDS[:200]):
        rig.send(SURFACE_TORQUE, [after])
        # Half a second that a busy machine takes is a silence, behind which it may wait again.
        with monkeypatch.context() as patched:
            patched.setattr(time, "monotonic_ns", lambda: now_ns)
            got = list(inbox.drain())
        assert [each.sample.time_ns for each in got if each.sample] == [after], before


def test_one_that_speaks_nonsense_is_not_waited_for_longer(rig: Ends) -> None:
    inbox = rig.inbox()
    rig.send(SURFACE_TORQUE, SECONDS)
    got: list[Received] = []

    def all_came() -> bool:
        rig.client.put(f"{rig.prefix}/{SURFACE_SPEED}", b"\xff\xff")
        got.extend(inbox.drain())
        return len(times_ns(got, SURFACE_TORQUE)) == len(SECONDS)

    wait_until(all_came, "torque")


def test_a_stray_time_in_a_backlog_holds_back_nothing_behind_it(rig: Ends) -> None:
    inbox = rig.inbox()
    rig.send(SURFACE_SPEED, SECONDS)
    rig.send(SURFACE_TORQUE, [*SECONDS[:50], 3600 * NS, *SECONDS[50:]])
    got = [each for each in inbox.drain() if each.sample and each.sample.time_ns < 3600 * NS]
    assert len(got) == 2 * len(SECONDS)
    assert most_ahead_ns(got) <= 250 * MS


def test_one_sample_ahead_of_its_own_channel_holds_back_nothing_behind_it(rig: Ends) -> None:
    """By 1.5 s: not so far that it is no part of any order, and far enough to be waited for."""
    inbox = rig.inbox()
    both = range(0, NS, 10 * MS)
    rig.send(SURFACE_TORQUE, both)
    rig.send(SURFACE_SPEED, both)
    received(inbox, 2 * len(both))
    later = range(NS, NS + 20 * MS, 10 * MS)
    rig.send(SURFACE_TORQUE, [2 * NS + 500 * MS, *later])
    begun = time.monotonic()
    got = received(inbox, 3)
    assert time.monotonic() - begun < 0.5 * queue.PATIENCE_NS / NS
    assert times_ns(got, SURFACE_TORQUE) == [2 * NS + 500 * MS, *later]


def test_nothing_is_held_back_at_the_end(rig: Ends) -> None:
    inbox = rig.inbox()
    rig.send(SURFACE_TORQUE, SECONDS)
    assert times_ns(list(inbox.drain(hold=False)), SURFACE_TORQUE) == list(SECONDS)


def test_of_what_was_sent_before_it_came_it_takes_the_last_alone(
    rig: Ends, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(queue, "HISTORY_S", 0.5)
    rig.send(SURFACE_SPEED, SECONDS[:10])
    time.sleep(1.0)  # that they are old
    rig.send(SURFACE_SPEED, SECONDS[10:20])
    inbox = rig.inbox((SURFACE_SPEED,))
    assert times_ns(received(inbox, 10), SURFACE_SPEED) == list(SECONDS[10:20])
