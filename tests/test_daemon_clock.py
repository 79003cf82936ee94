"""A source whose clock is not ours: it drifts, and it is set. Its own time is the only one that counts."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, cast

import pytest

from tests.daemons import Daemon, Post, daemon, post
from tests.live import WARM_S, LiveRig, false_ones, others, undisturbed
from tests.rigs import BEGUN_NS, NS, RATE, SHORT
from vsensor.bus import SURFACE_CACHE, Outbox, open_session
from vsensor.config import Bus
from vsensor.messages import BIT_ESTIMATE, Estimate, Status
from vsensor.messages.books import refused
from vsensor.messages.vsensor_pb2 import GOOD
from vsensor.quality import Reason
from vsensor.recording.reader import Session

pytestmark = pytest.mark.process

HOUR_NS = 3600 * NS
DRIFTS = (2e-4, 1e-2, -1e-2)


class Place(NamedTuple):
    """A rig, and a listener beside it."""

    rig: LiveRig
    near: Post
    sensor: Daemon

    def settled(self) -> Status:
        """The status once each sample has come."""
        return self.near.await_status(
            lambda status: sum(c.received for c in status.channels) == len(self.rig.sent),
            "all that was sent",
        )

    @property
    def estimates(self) -> list[Estimate]:
        """All, from the session of a sensor that has ended: a listener may miss one, for nobody waits."""
        (session,) = self.sensor.sessions
        messages = Session(session).messages((BIT_ESTIMATE,))
        return [cast("Estimate", record.message) for record in messages]


@contextmanager
def place(bus: Bus, folder: Path) -> Iterator[Place]:
    with (
        daemon(SHORT, bus, folder) as sensor,
        post(sensor) as near,
        open_session(bus, "client") as session,
    ):
        outbox = Outbox(session, SHORT.prefix, reliable=True, cache=SURFACE_CACHE)
        yield Place(LiveRig(outbox, BEGUN_NS), near, sensor)
        assert sensor.end() == 0


def test_a_source_clock_that_drifts_against_ours_changes_no_estimate(bus: Bus, tmp_path: Path) -> None:
    """By years it is off besides."""
    with place(bus, tmp_path) as at:
        at.rig.live(WARM_S)
        for drift in DRIFTS:
            at.rig.pace = 1 + drift
            at.rig.live(3)
        status = at.settled()
        assert status.restarts == 0
        assert [(c.accepted, refused(c)) for c in status.channels] == [(at.rig.readings, 0)] * 2
    told = at.estimates
    assert others(told, undisturbed(at.rig.sent)) == []
    assert any(estimate.quality == GOOD for estimate in told[-RATE:])
    assert list(false_ones(told, BEGUN_NS)) == []


def test_where_the_source_clock_is_set_it_begins_anew_and_nothing_is_good_before_it_is_warm(
    bus: Bus, tmp_path: Path
) -> None:
    with place(bus, tmp_path) as at:
        begun = []
        for shift_ns in (0, HOUR_NS, -2 * HOUR_NS):
            at.rig.begun_ns += shift_ns
            begun.append(at.rig.begun_ns)
            at.rig.live(2 * WARM_S)
        status = at.settled()
    told = at.estimates
    assert status.restarts == 2
    assert all(c.jumped <= 2 for c in status.channels)  # one of each channel, each time
    assert all(c.received == c.accepted + refused(c) for c in status.channels)
    for begun_ns in begun:
        part = [each for each in told if 0 < each.time_ns - begun_ns < HOUR_NS // 2]
        assert [each.number for each in part] == list(range(len(part)))
        assert part[0].reasons & Reason.WARMING_UP
        assert part[-1].quality == GOOD
        assert list(false_ones(part, begun_ns)) == []
