"""Two sensors of one rig: one speaks, the other ends or stands by, and takes its place."""

import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh

from tests.daemons import Daemon, Post, daemon, free_bus, wait_until
from tests.rigs import NS, RATE, SHORT, samples, simulated
from vsensor.bus import command, open_session, wait_for_sensor
from vsensor.config import Bus
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

pytestmark = pytest.mark.process

READINGS = simulated(12)


class Hub(Post):
    """A router between the rig and its sensors, and the rig itself."""

    def __init__(self, session: zenoh.Session, bus: Bus) -> None:
        super().__init__(session, SHORT.prefix)
        self.bus = bus


@pytest.fixture
def hub() -> Iterator[Hub]:
    bus = free_bus()
    with open_session(bus, "daemon") as session:
        yield Hub(session, bus)


def joined(hub: Hub) -> Bus:
    """A place of its own, joined to the router."""
    return free_bus().model_copy(update={"connect": hub.bus.listen})


def folder(base: Path, name: str) -> Path:
    place = base / name
    place.mkdir()
    return place


def test_a_second_sensor_of_a_rig_ends_and_says_what_to_do(hub: Hub, tmp_path: Path) -> None:
    with daemon(SHORT, joined(hub), folder(tmp_path, "first")) as first:
        wait_until(lambda: wait_for_sensor(hub.session, hub.prefix), "the first sensor")
        second = Daemon(SHORT, joined(hub), folder(tmp_path, "second"))
        assert second.process.wait(60) == 1
        assert "another sensor speaks for rigs/test, since before" in second.said
        assert "--stand-by" in second.said
        assert "Traceback" not in second.said
        assert first.process.poll() is None


def test_one_that_stands_by_is_silent_and_takes_the_place_of_one_that_was_killed(
    hub: Hub, tmp_path: Path
) -> None:
    """Without warming up, and with what the other was told."""
    begun_ns = time.time_ns()
    half = 2 * RATE * 6
    feed = samples(READINGS, begun_ns)
    with (
        daemon(SHORT, joined(hub), folder(tmp_path, "first")) as first,
        daemon(SHORT, joined(hub), folder(tmp_path, "second"), "--stand-by") as second,
    ):
        second.await_saying("standing by")
        hub.send(feed[:half])
        # Of so many estimates at once a busy network may drop one, and be it the last: the sensor counts.
        hub.await_status(lambda status: status.ticks == 6 * RATE, "all ticks of the first")
        wait_until(lambda: bool(hub.estimates), "estimates")
        told = [estimate.number for estimate in hub.estimates]
        assert told == sorted(set(told))  # each once: one speaks
        command(hub.session, hub.prefix, "longer 30 m")
        first.end(signal.SIGKILL)
        second.await_saying("taking its place")
        wait_until(lambda: wait_for_sensor(hub.session, hub.prefix), "the second sensor")
        hub.send(feed[half:])
        status = hub.await_status(lambda status: status.ticks == len(READINGS), "all ticks of the second")
        assert status.string_length_m == 1230
        after = [estimate for estimate in hub.estimates if estimate.number >= 6 * RATE]
        assert after
        assert all(estimate.HasField("now_bit_speed_rad_s") for estimate in after)
        assert after[0].time_ns - begun_ns < 6.2 * NS
        assert second.end(signal.SIGTERM) == 0
        (session,) = second.sessions
    assert verify(Session(session), Engine(SHORT)).exact
