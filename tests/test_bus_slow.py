"""A client that takes messages slower than they come, or not at all, does not hold the loop up."""

import os
import resource
import signal
import statistics
import subprocess
import sys
import time

import pytest

from tests.view_rig import estimate, tick
from vsensor.bus import Feed, Outbox, open_session
from vsensor.config import Bus
from vsensor.messages import BIT_ESTIMATE, SENSOR_TICK, Tick

TICKS = 6
"""Of one turn of a loop that catches up."""
LISTENER = """
import sys, time
from vsensor.bus import open_session
from vsensor.config import Bus
with open_session(Bus(listen=(sys.argv[1],)), "client") as session:
    heard = session.declare_subscriber("rigs/t/**", lambda sample: None)
    print("listening", flush=True)
    time.sleep(600)
"""
ENOUGH = 40_000
"""Estimates that fill what the kernel keeps of a connection, and Zenoh's own queue."""


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


@pytest.mark.process
def test_a_client_that_stands_still_is_not_waited_for(bus: Bus) -> None:
    with open_session(bus, "daemon") as session:
        waited = _waits_for_one_that_stands_still(Outbox(session, "rigs/t", reliable=False), bus)
    # Zenoh's default waits some 700 times here; on a busy machine the thread may meet another in a lock.
    assert waited < 20


def _waits_for_one_that_stands_still(outbox: Outbox, bus: Bus) -> int:
    words = [sys.executable, "-c", LISTENER, bus.listen[0]]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as listener:
        assert listener.stdout is not None
        assert listener.stdout.readline() == "listening\n"
        os.kill(listener.pid, signal.SIGSTOP)
        before = slept()
        for number in range(ENOUGH):
            outbox.put(BIT_ESTIMATE, estimate(number))
        waited = slept() - before
        listener.kill()
    return waited
