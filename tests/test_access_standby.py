"""Two sensors of one rig behind the roles of the examples: one stands by, and takes a killed one's place."""

import json
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
import zenoh

from tests.daemons import Post, daemon, free_bus, wait_until
from tests.live import WARM_S, LiveRig
from tests.locks import Etc
from tests.rigs import RATE, SHORT
from vsensor.bus import SURFACE_CACHE, Outbox, command, open_session, wait_for_sensor
from vsensor.config import Bus
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

pytestmark = pytest.mark.process


class Behind(NamedTuple):
    """A router of its own behind its lock, and who is joined to it."""

    sensor: Bus
    surface: zenoh.Session
    driller: zenoh.Session
    viewer: zenoh.Session


@pytest.fixture
def router(tmp_path: Path) -> Iterator[Behind]:
    etc = Etc(tmp_path / "etc")
    bus = etc.bus("router")
    config = zenoh.Config.from_file(etc.zenoh("router"))
    config.insert_json5("listen/endpoints", json.dumps(bus.listen))

    def joined(role: str) -> Bus:
        return Bus(listen=("tcp/127.0.0.1:0",), connect=bus.listen, client_zenoh_config=etc.zenoh(role))

    with (
        zenoh.open(config),
        open_session(joined("surface"), "client") as surface,
        open_session(joined("driller"), "client") as driller,
        open_session(joined("viewer"), "client") as viewer,
    ):
        sensor = Bus(connect=bus.listen, zenoh_config=etc.zenoh("sensor"))
        yield Behind(sensor, surface, driller, viewer)


def place(router: Behind, folder: Path) -> tuple[Bus, Path]:
    """Each sensor has a port and a folder of its own."""
    folder.mkdir()
    return router.sensor.model_copy(update={"listen": free_bus().listen}), folder


def test_one_that_stands_by_behind_a_lock_takes_the_place_of_one_that_was_killed(
    router: Behind, tmp_path: Path
) -> None:
    near = Post(router.viewer, SHORT.prefix)
    rig = LiveRig(Outbox(router.surface, SHORT.prefix, reliable=True, cache=SURFACE_CACHE))
    with (
        daemon(SHORT, *place(router, tmp_path / "first")) as first,
        daemon(SHORT, *place(router, tmp_path / "second"), "--stand-by") as second,
    ):
        second.await_saying("standing by")
        rig.live(WARM_S)
        wait_until(
            lambda: bool(near.estimates) and near.estimates[-1].number == rig.readings - 1, "estimates"
        )
        told = [estimate.number for estimate in near.estimates]
        assert told == sorted(set(told))  # each once: one speaks
        command(router.driller, SHORT.prefix, "longer 30 m")
        first.end(signal.SIGKILL)
        second.await_saying("taking its place")
        wait_until(lambda: wait_for_sensor(router.viewer, SHORT.prefix), "the second sensor")
        killed = rig.readings
        rig.live(2)
        status = near.await_status(lambda status: status.ticks == rig.readings, "ticks of the second")
        assert status.string_length_m == 1230
        after = [estimate for estimate in near.estimates if estimate.number >= killed]
        assert len(after) > RATE
        assert all(estimate.HasField("now_bit_speed_rad_s") for estimate in after)
        assert second.end(signal.SIGTERM) == 0
        (session,) = second.sessions
    assert verify(Session(session), Engine(SHORT)).exact
