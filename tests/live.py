"""A rig that publishes in real time, whatever happens to who listens; and what should come of it."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.daemons import Daemon, Post, daemon, post
from tests.rigs import NS, RATE, SHORT, Surface, samples, simulated
from vsensor.bus import SURFACE_CACHE, Outbox, open_session
from vsensor.config import Bus
from vsensor.messages import Estimate
from vsensor.messages.vsensor_pb2 import GOOD
from vsensor.service.engine import Engine

WARM_S = 4.0
"""The short rig has answers by then."""
READINGS = simulated(90)
BIT_TIME_S = np.array([reading.bit_time_s for reading in READINGS])
BIT_SPEED = np.array([reading.bit_speed for reading in READINGS])


class LiveRig:
    """The short rig in smooth drilling, by a clock of its own."""

    def __init__(self, outbox: Outbox, begun_ns: int | None = None, pace: float = 1.0) -> None:
        self.begun_ns = time.time_ns() if begun_ns is None else begun_ns
        """When its clock says that it began; it may be set anew."""
        self.pace = pace
        """Seconds of its clock in one of ours."""
        self.sent: Surface = []
        self._outbox = outbox
        self._number = 0

    @property
    def readings(self) -> int:
        """How many readings were sent, of both channels each."""
        return len(self.sent) // 2

    def live(self, seconds: float) -> None:
        """Publish what is due, for so long by our clock."""
        begun, first = time.monotonic(), self._number
        while (past := time.monotonic() - begun) < seconds:
            while self._number < first + past * self.pace * RATE:
                self._send_one()
            time.sleep(0.002)

    def _send_one(self) -> None:
        sent = samples([READINGS[self._number]], self.begun_ns, self._number)
        for topic, sample in sent:
            self._outbox.put(topic, sample)
        self.sent += sent
        self._number += 1


class AtWork(NamedTuple):
    """A daemon, a listener beside it, and the rig that feeds it over a session of its own."""

    sensor: Daemon
    near: Post
    rig: LiveRig


@contextmanager
def at_work(bus: Bus, folder: Path) -> Iterator[AtWork]:
    """A daemon that has its first answers."""
    with daemon(SHORT, bus, folder) as sensor, post(sensor) as near, open_session(bus, "client") as session:
        rig = LiveRig(Outbox(session, SHORT.prefix, reliable=True, cache=SURFACE_CACHE))
        rig.live(WARM_S)
        yield AtWork(sensor, near, rig)


def undisturbed(sent: Surface) -> dict[int, bytes]:
    """What comes of these samples where nothing happens, by the time of the tick."""
    engine = Engine(SHORT)
    return {
        estimate.time_ns: estimate.SerializeToString(deterministic=True)
        for topic, sample in sent
        for _, estimate in engine.take(topic, sample)
    }


def others(told: Sequence[Estimate], expected: dict[int, bytes]) -> list[Estimate]:
    """Estimates that are not, bit for bit, the expected ones of their time.

    A loop that is short of time, as on a busy machine, leaves the forecast out: of those, what is confirmed.
    """
    return [each for each in told if not _is_expected(each, expected[each.time_ns])]


def _is_expected(told: Estimate, expected: bytes) -> bool:
    if not told.forecast_shed:
        return expected == told.SerializeToString(deterministic=True)
    other = Estimate.FromString(expected)
    return (told.confirmed_bit_speed_rad_s, told.confirmed_bit_torque_nm, told.reasons) == (
        other.confirmed_bit_speed_rad_s,
        other.confirmed_bit_torque_nm,
        other.reasons,
    )


def false_ones(told: Sequence[Estimate], begun_ns: int) -> Iterator[str]:
    """Estimates that are called good and are not: further from the truth than six times their deviation."""
    for each in told:
        if each.quality != GOOD or not each.HasField("confirmed_bit_speed_rad_s"):
            continue
        truth = np.interp((each.confirmed_time_ns - begun_ns) / NS, BIT_TIME_S, BIT_SPEED)
        miss = abs(each.confirmed_bit_speed_rad_s - truth)
        if miss > 6 * each.confirmed_bit_speed_std_rad_s:
            yield f"tick {each.number}: {miss:.3f} rad/s off, {each.confirmed_bit_speed_std_rad_s:.3f} said"
