"""A daemon whose link to the rig is cut: it goes on where it was, or says how much it has lost."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.daemons import Daemon, Post, daemon, free_bus, post
from tests.link import Link, link
from tests.live import WARM_S, LiveRig, false_ones, others, undisturbed
from tests.rigs import RATE, SHORT
from vsensor.bus import SURFACE_CACHE, Outbox, open_session
from vsensor.config import Bus
from vsensor.messages import Status
from vsensor.messages.books import refused
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

pytestmark = pytest.mark.process


class Far(NamedTuple):
    """A rig beyond a link, and a listener before it."""

    sensor: Daemon
    wire: Link
    near: Post
    rig: LiveRig

    def settled(self) -> Status:
        """The status once each sample that was sent has come, or is known to be lost."""

        def all_are_known(status: Status) -> bool:
            return sum(c.received for c in status.channels) + status.bus_missed >= len(self.rig.sent)

        return self.near.await_status(all_are_known, "all that was sent")


@contextmanager
def far(folder: Path, cache: int) -> Iterator[Far]:
    with (
        daemon(SHORT, free_bus(), folder) as sensor,
        link(sensor.rig.bus) as wire,
        post(sensor) as near,
        open_session(wire.bus, "client") as session,
    ):
        yield Far(sensor, wire, near, LiveRig(Outbox(session, SHORT.prefix, reliable=True, cache=cache)))


@pytest.mark.parametrize("cut_s", [2, 60])
def test_over_a_cut_that_the_rigs_cache_reaches_estimates_are_as_if_there_were_none(
    tmp_path: Path, cut_s: int
) -> None:
    """One channel's backlog comes before the other's: that is no silence of the other."""
    with far(tmp_path, SURFACE_CACHE) as end:
        end.rig.live(WARM_S)
        end.wire.cut()
        end.rig.live(cut_s)
        end.wire.mend()
        end.rig.live(3)
        status = end.settled()
        assert (status.bus_missed, status.restarts) == (0, 0)
        assert [(c.accepted, c.lost) for c in status.channels] == [(end.rig.readings, 0)] * 2
        assert status.ticks == end.rig.readings
        assert others(end.near.estimates, undisturbed(end.rig.sent)) == []


def test_what_the_rigs_cache_no_longer_has_is_counted_and_nothing_false_is_called_good(
    tmp_path: Path,
) -> None:
    with far(tmp_path, cache=RATE) as end:
        end.rig.live(WARM_S)
        end.wire.cut()
        end.rig.live(4)
        end.wire.mend()
        end.rig.live(2 * WARM_S)
        status = end.settled()
        came = [(c.received, c.received + c.lost) for c in status.channels]
        assert [all_of for _, all_of in came] == [end.rig.readings] * 2
        assert sum(received for received, _ in came) + status.bus_missed == len(end.rig.sent)
        assert status.bus_missed > 2 * RATE
        assert all(c.received == c.accepted + refused(c) for c in status.channels)
        after = [each for each in end.near.estimates if each.time_ns > end.rig.sent[-RATE][1].time_ns]
        assert after
        assert list(false_ones(end.near.estimates, end.rig.begun_ns)) == []
        assert end.sensor.end() == 0
        (session,) = end.sensor.sessions
    assert verify(Session(session), Engine(SHORT)).exact


def test_a_daemon_that_starts_later_begins_with_what_the_rig_sent_before(tmp_path: Path, bus: Bus) -> None:
    """It need not warm up: all of it is used, though one channel's comes before the other's."""
    with open_session(bus, "daemon") as hub:
        rig = LiveRig(Outbox(hub, SHORT.prefix, reliable=True, cache=SURFACE_CACHE))
        rig.live(WARM_S)
        joined = free_bus().model_copy(update={"connect": bus.listen})
        with daemon(SHORT, joined, tmp_path) as sensor, post(sensor) as near:
            near.await_status(lambda status: status.ticks == rig.readings, "ticks of before")
            rig.live(1)
            status = near.await_status(lambda status: status.ticks == rig.readings, "ticks of after")
            assert status.restarts == 0
            assert [(c.accepted, c.lost) for c in status.channels] == [(rig.readings, 0)] * 2
            expected = undisturbed(rig.sent)
            now = [each for each in near.estimates if each.time_ns > rig.sent[-RATE][1].time_ns]
            assert now
            assert others(now, expected) == []
