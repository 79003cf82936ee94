"""A daemon that is stopped for longer than its links live, and goes on."""

import os
import signal
from pathlib import Path

import pytest

from tests.live import WARM_S, at_work, others, undisturbed
from tests.rigs import RATE, SHORT
from vsensor.config import Bus
from vsensor.messages import SENSOR_TICK, Tick
from vsensor.messages.books import refused
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

pytestmark = pytest.mark.process

STOPPED_S = 12.0
"""Zenoh holds a link for dead after ten."""


def test_after_a_stop_that_ends_its_links_it_catches_up_and_estimates_are_as_if_there_were_none(
    bus: Bus, tmp_path: Path
) -> None:
    with at_work(bus, tmp_path) as (sensor, near, rig):
        os.kill(sensor.process.pid, signal.SIGSTOP)
        rig.live(STOPPED_S)
        os.kill(sensor.process.pid, signal.SIGCONT)
        rig.live(WARM_S)
        status = near.await_status(
            lambda status: sum(c.received for c in status.channels) + status.bus_missed >= len(rig.sent),
            "all that was sent",
        )
        assert (status.bus_missed, status.restarts) == (0, 0)
        assert [(c.received, c.accepted, c.lost) for c in status.channels] == [(rig.readings,) * 2 + (0,)] * 2
        assert [refused(c) for c in status.channels] == [0, 0]
        assert status.ticks == rig.readings
        assert status.slots_skipped > 0.8 * STOPPED_S * RATE
        assert status.slots_due == status.slots_run + status.slots_skipped
        assert others(near.estimates, undisturbed(rig.sent)) == []
        assert sensor.end() == 0
        (path,) = sensor.sessions
    recorded = Session(path)
    assert verify(recorded, Engine(SHORT)).exact
    ticks = [r.message for r in recorded.messages((SENSOR_TICK,)) if isinstance(r.message, Tick)]
    assert any(tick.caught_up for tick in ticks)
    # On a busy machine slots are skipped before the stop, too: no more is made up for there than had no tick.
    before = [tick for tick in ticks if tick.number < (WARM_S - 1) * RATE]
    without = before[-1].slot - before[0].slot + 1 - len({tick.slot for tick in before})
    assert sum(tick.caught_up for tick in before) <= without
