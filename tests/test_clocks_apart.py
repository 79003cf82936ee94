"""Channels that two publishers tell, and clocks that are apart: said in words that lead to the cause."""

import pytest

from tests.test_intake import BEGUN, MS, SMALL, S, T
from vsensor.grid import NS
from vsensor.intake import Intake
from vsensor.messages import Event, Sample
from vsensor.quality import Reason
from vsensor.service.watch import Watch


def seen(times_s: list[tuple[float | None, float | None]]) -> list[list[Event]]:
    """What is told second by second of the newest times of torque and of speed."""
    watching = Watch(SMALL)
    return [
        watching.sources((), [None if t is None else BEGUN + round(t * NS) for t in pair]) for pair in times_s
    ]


@pytest.mark.parametrize(
    ("ahead_s", "told"),
    [(3600.0, "speed's is 3600.0 s ahead of torque's"), (-1.5, "speed's is 1.5 s behind torque's")],
)
def test_clocks_that_are_apart_are_told_once_and_that_they_agree_again(ahead_s: float, told: str) -> None:
    apart = [(k, k + ahead_s) for k in range(10)]
    agree = [(10.0, 10.01), (11.0, 11.01)]
    events = [event for events in seen([*apart, *agree]) for event in events]
    assert [(event.name, event.begins) for event in events] == [
        ("clocks_apart", True),
        ("clocks_apart", False),
    ]
    assert events[0].text == f"the channels' clocks are apart: {told}"


def test_a_silent_channel_a_backlog_and_a_moment_are_no_clocks_apart() -> None:
    silent = [(3.0, 3.0 + k) for k in range(20)]
    never = [(None, float(k)) for k in range(20)]
    backlog = [(20.0 + k, 5.0 * k) for k in range(6)]
    moment = [(k, k + 0.2) for k in range(20)]
    hiccups = [(k, k + (0.6 if k % 2 else 0.0)) for k in range(20)]
    shortly = [(k, k + (5.0 if 5 <= k < 8 else 0.0)) for k in range(20)]
    for times_s in (silent, never, backlog, moment, hiccups, shortly):
        assert not any(seen([(t, s) for t, s in times_s]))


def test_a_speed_an_hour_ahead_is_told_of_with_its_stale_torque() -> None:
    intake, watching = Intake(SMALL), Watch(SMALL)
    events: list[Event] = []
    reasons: set[int] = set()
    for k in range(1000):
        for topic, ahead in ((T, 0), (S, 3600 * NS)):
            sample = Sample(time_ns=BEGUN + k * 10 * MS + ahead, value=k % 7 / 50, sequence=k)
            reasons |= {tick.reasons for tick in intake.take(topic, sample)}
        if k % 100 == 99:
            newest_ns = [channel.newest_ns for channel in intake.channels.values()]
            events += watching.sources(intake.contested, newest_ns)
    assert reasons == {Reason.STALE_TORQUE}
    assert [event.text for event in events] == [
        "the channels' clocks are apart: speed's is 3600.0 s ahead of torque's"
    ]


def test_two_publishers_of_a_channel_are_told_and_that_one_is_left() -> None:
    watching = Watch(SMALL)
    told = [watching.sources(contested, (None, None)) for contested in ((), (T,), (T, S), ())]
    assert [[(event.name, event.begins) for event in events] for events in told] == [
        [],
        [("contested", True)],
        [],
        [("contested", False)],
    ]
    assert told[1][0].text.endswith(": surface/torque")
