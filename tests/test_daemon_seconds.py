"""What is due once a second is done in parts, a part a turn, and yet each second, at any rate."""

from collections.abc import Callable
from itertools import count

import pytest

from tests.daemons import free_bus
from tests.strings import PIPE, rig
from vsensor.bus import open_session
from vsensor.messages import Status
from vsensor.service.daemon import Daemon
from vsensor.service.engine import Engine
from vsensor.service.pace import Pace
from vsensor.service.realtime import achieve


class Instant:
    """A clock on which a sleep takes no time."""

    def __init__(self) -> None:
        self.time = 0

    def now_ns(self) -> int:
        return self.time

    def sleep_until(self, deadline_ns: int) -> None:
        self.time = max(self.time, deadline_ns)


def after(turns: int) -> Callable[[], bool]:
    """Whether so many turns have been."""
    done = count(1)
    return lambda: next(done) >= turns


@pytest.mark.parametrize("rate", [2.0, 20.0, 400.0])
def test_each_second_is_told_of_once(rate: float) -> None:
    bus = free_bus()
    configured = rig(PIPE, rate=rate).model_copy(update={"bus": bus})
    heard: list[Status] = []
    turns = round(10.5 * rate)
    with open_session(bus, "daemon") as session:
        sensor = Daemon(configured, Engine(configured), session, None, achieve(configured.loop))
        sensor.run(Pace(rate, Instant()), (heard.append,), after(turns))
    assert len(heard) == 10
    # Made when the second had just passed, but for what is left to the turns behind it.
    for second, status in enumerate(heard, 1):
        assert second * rate <= status.slots_due <= second * rate + max(1, 0.15 * rate)
    assert sensor.health.status.slots_due == turns
