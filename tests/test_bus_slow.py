"""A client that takes the daemon's messages slower than they come in a bunch does not hold the loop up."""

import resource
import statistics
import time

import pytest

from tests.view_rig import estimate, tick
from vsensor.bus import Feed, Outbox, open_session
from vsensor.config import Bus
from vsensor.messages import BIT_ESTIMATE, SENSOR_TICK, Tick

TICKS = 6
"""Of one turn of a loop that catches up."""


def slept() -> int:
    """How often this thread has waited for something so far."""
    return resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw


@pytest.mark.process
def test_a_bunch_of_messages_is_published_without_waiting_for_who_hears_them(bus: Bus) -> None:
    with (
        open_session(bus, "daemon") as session,
        open_session(bus, "client") as listener,
    ):
        outbox = Outbox(session, "rigs/t", reliable=False)
        feed = Feed(listener, "rigs/t", (SENSOR_TICK, BIT_ESTIMATE))
        heard = 0
        waited = []
        for first in range(0, 100 * TICKS, TICKS):
            before = slept()
            for number in range(first, first + TICKS):
                outbox.put(SENSOR_TICK, tick(number))
                outbox.put(BIT_ESTIMATE, estimate(number))
            waited.append(slept() - before)
            time.sleep(0.005)
            heard += sum(isinstance(message, Tick) for _, message in feed.drain())
    assert heard > 0
    assert statistics.median(waited) == 0
