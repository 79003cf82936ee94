"""What has come before a slot is run ahead of it: what is told in the slot is the same."""

import time
from collections.abc import Callable, Iterator
from typing import cast

import pytest

from tests.daemons import free_bus
from tests.rigs import RATE, SHORT, Surface, samples, simulated
from vsensor.bus import Received, open_session
from vsensor.messages import BIT_ESTIMATE, SENSOR_TICK, STRING_PROFILE, SURFACE_TORQUE, Message
from vsensor.service.daemon import Daemon
from vsensor.service.engine import Engine
from vsensor.service.pace import Pace, Slot
from vsensor.service.profile import Profiler, profile_of, reckon
from vsensor.service.realtime import achieve

SPARSE = 7
"""Of the speed every seventh sample comes, and completes as many ticks: profiles are due among them."""
FEED: Surface = [
    (topic, sample)
    for topic, sample in samples(simulated(10))
    if topic == SURFACE_TORQUE or not sample.sequence % SPARSE
]
WANTED = (BIT_ESTIMATE, STRING_PROFILE)


class Waiting:
    """Samples that wait, in place of those that come over a bus."""

    def __init__(self) -> None:
        self.samples: Surface = []

    def drain(self, more: Callable[[], bool], **_: bool) -> Iterator[Received]:
        while self.samples and more():
            topic, sample = self.samples.pop(0)
            yield Received(topic, 0, sample)


def expected() -> dict[str, list[bytes]]:
    """What comes of the samples one by one."""
    engine = Engine(SHORT)
    told: dict[str, list[bytes]] = {topic: [] for topic in WANTED}
    profiler = Profiler(SHORT, engine.estimator)
    for topic, sample in FEED:
        for _, estimate in engine.take(topic, sample):
            told[BIT_ESTIMATE].append(estimate.SerializeToString())
            if noted := profiler.note(estimate):
                told[STRING_PROFILE].append(profile_of(reckon(noted)).SerializeToString())
    return told


@pytest.mark.parametrize("ahead_s", [None, -1.0, 3600.0])
def test_what_is_told_is_the_same_whether_a_slot_was_prepared_or_not(ahead_s: float | None) -> None:
    """Not at all, with no time left, or with all the time there is."""
    rig = SHORT.model_copy(update={"bus": free_bus()})
    told: dict[str, list[bytes]] = {topic: [] for topic in WANTED}

    def send(topic: str, message: Message) -> bytes:
        data = message.SerializeToString()
        if topic in WANTED:
            told[topic].append(data)
        return data

    with open_session(rig.bus, "daemon") as session, pytest.MonkeyPatch.context() as patched:
        sensor = Daemon(rig, Engine(rig), session, None, achieve(rig.loop))
        waiting = Waiting()
        patched.setattr(sensor, "_inbox", waiting)
        patched.setattr(sensor.voice, "send", send)
        for number, start in enumerate(range(0, len(FEED), 10)):
            waiting.samples += FEED[start : start + 10]
            if ahead_s is not None:
                before = len(told[BIT_ESTIMATE])
                sensor.prepare(time.monotonic_ns() + round(ahead_s * 1e9))
                assert len(told[BIT_ESTIMATE]) == before
                sensor._tell_prepared()
            sensor._turn(Slot(number, 0, 0))
            while waiting.samples:  # a turn takes no longer than half a slot
                sensor._turn(Slot(number, 0, 0))
        sensor._chores.finish()  # profiles are told when a turn has time
    assert told == expected()
    assert len(told[STRING_PROFILE]) > RATE


@pytest.mark.parametrize(("rate", "ahead"), [(100.0, True), (2000.0, False)])
def test_answers_that_are_ready_go_out_ahead_of_all_else_where_a_slot_has_time(
    rate: float, ahead: bool
) -> None:
    rig = SHORT.model_copy(update={"bus": free_bus(), "loop": SHORT.loop.model_copy(update={"rate": rate})})
    told: list[str] = []

    def send(topic: str, message: Message) -> bytes:
        told.append(topic)
        return message.SerializeToString()

    with open_session(rig.bus, "daemon") as session, pytest.MonkeyPatch.context() as patched:
        sensor = Daemon(rig, Engine(rig), session, None, achieve(rig.loop))
        waiting = Waiting()
        patched.setattr(sensor, "_inbox", waiting)
        patched.setattr(sensor.voice, "send", send)
        waiting.samples += FEED[:4]
        sensor.prepare(time.monotonic_ns() + 10**9)
        assert told == []
        stepped_back_ns = sensor._tell_prepared()
        assert (stepped_back_ns > 0) == ahead
        answers = list(told)
        assert set(answers) == ({BIT_ESTIMATE} if ahead else set())
        sensor._turn(Slot(1, 0, 0))
    assert told.count(BIT_ESTIMATE) == told.count(SENSOR_TICK) > 0
    assert told[: len(answers)] == answers


def test_a_tick_with_a_profile_is_prepared_only_where_there_is_time_for_both() -> None:
    rig = SHORT.model_copy(update={"bus": free_bus()})
    with open_session(rig.bus, "daemon") as session, pytest.MonkeyPatch.context() as patched:
        sensor = Daemon(rig, Engine(rig), session, None, achieve(rig.loop))
        waiting = Waiting()
        patched.setattr(sensor, "_inbox", waiting)
        waiting.samples += FEED[:20]
        sensor._profiler.took_ns = 4 * 10**9
        assert sensor._profiler.due(sensor._engine.intake.next_number)
        assert not sensor.prepare(time.monotonic_ns() + 3 * 10**9)
        assert len(waiting.samples) == 20
        assert sensor.prepare(time.monotonic_ns() + 7 * 10**9)
        assert not waiting.samples


class Slots:
    """So many slots, one right behind the other."""

    start_ns = 0

    def __init__(self, count: int) -> None:
        self._count = count

    def slots(self) -> Iterator[Slot]:
        for number in range(1, self._count + 1):
            yield Slot(number, 0, 0)


@pytest.mark.parametrize(("rate", "turns"), [(50.0, 1), (100.0, 1), (1000.0, 10)])
def test_the_recorder_is_given_what_is_for_it_a_hundred_times_a_second_at_the_most(
    rate: float, turns: int
) -> None:
    """It would be woken as often; and no more than 10 ms of a record are lost with the daemon."""
    rig = SHORT.model_copy(update={"bus": free_bus(), "loop": SHORT.loop.model_copy(update={"rate": rate})})
    handed: list[int] = []
    with open_session(rig.bus, "daemon") as session, pytest.MonkeyPatch.context() as patched:
        sensor = Daemon(rig, Engine(rig), session, None, achieve(rig.loop))
        patched.setattr(sensor.voice, "hand_on", lambda: handed.append(sensor.health.slots_run))
        sensor.run(cast("Pace", Slots(30)), (), lambda: False)
    assert handed == [*range(turns, 31, turns), 30]
