"""A daemon and a rig that meet at a router: it is killed, and another takes its place."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.daemons import daemon, free_bus, post
from tests.live import WARM_S, LiveRig, others, undisturbed
from tests.rigs import SHORT
from vsensor.bus import SURFACE_CACHE, Outbox, open_session
from vsensor.config import Bus

pytestmark = pytest.mark.process

ROUTER = """
import signal, sys, zenoh
config = zenoh.Config.from_json5(
    '{mode: "router", listen: {endpoints: ["%s"]}, scouting: {multicast: {enabled: false}}}' % sys.argv[1]
)
with zenoh.open(config):
    print("up", flush=True)
    signal.pause()
"""


class Router:
    """Zenoh's own, as a process that can be killed and started again."""

    def __init__(self, bus: Bus) -> None:
        self._command = [sys.executable, "-c", ROUTER, bus.listen[0]]
        self.start()

    def start(self) -> None:
        """Start it; it listens on return."""
        self._process = subprocess.Popen(self._command, stdout=subprocess.PIPE)
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == b"up\n"

    def kill(self) -> None:
        """Kill it."""
        self._process.kill()
        self._process.communicate()


@contextmanager
def router(bus: Bus) -> Iterator[Router]:
    """One that is there, until it is killed."""
    started = Router(bus)
    try:
        yield started
    finally:
        started.kill()


def test_over_a_router_that_was_killed_estimates_are_as_if_it_had_not_been(bus: Bus, tmp_path: Path) -> None:
    joined = free_bus().model_copy(update={"connect": bus.listen})
    with (
        router(bus) as between,
        daemon(SHORT, joined, tmp_path) as sensor,
        post(sensor) as near,
        open_session(Bus(connect=bus.listen), "client") as session,
    ):
        rig = LiveRig(Outbox(session, SHORT.prefix, reliable=True, cache=SURFACE_CACHE))
        rig.live(WARM_S)
        near.await_status(lambda status: status.ticks == rig.readings, "ticks")
        between.kill()
        rig.live(2)
        between.start()
        rig.live(3)
        status = near.await_status(lambda status: status.ticks == rig.readings, "ticks of between and after")
        assert (status.bus_missed, status.restarts) == (0, 0)
        assert [(c.accepted, c.lost) for c in status.channels] == [(rig.readings, 0)] * 2
        assert others(near.estimates, undisturbed(rig.sent)) == []
        assert sensor.end() == 0
