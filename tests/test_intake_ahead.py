"""A sample ahead of its channel, by less than begins all anew: the next bears it out, or it was a stray."""

import pytest

from tests.test_intake import RESTART_GAP, SMALL, Feed, S, T, both, one, reading, steps, ticks
from vsensor.intake import Input, Intake
from vsensor.messages.books import REFUSALS
from vsensor.quality import Reason


def refused(intake: Intake, topic: str) -> dict[str, int]:
    counts = intake.channels[topic].counts
    return {reason: count for reason in REFUSALS if (count := getattr(counts, reason))}


@pytest.mark.parametrize("stray", [T, S])
@pytest.mark.parametrize("ahead_s", [0.3, 1.0, 1.9])
@pytest.mark.parametrize("rate", [100.0, 5.0])
def test_a_stray_falsifies_nothing(stray: str, ahead_s: float, rate: float) -> None:
    ahead_s += 1 / rate
    intake = Intake(SMALL)
    feed = [*both(steps(0, 5, rate), 8.0), reading(stray, 5 + ahead_s, 20.0), *both(steps(5, 10, rate), 8.0)]
    assert ticks(feed, intake) == ticks(both(steps(0, 10, rate), 8.0))
    assert refused(intake, stray) == {"jumped": 1}
    assert intake.restarts == 0


@pytest.mark.parametrize("cut", [[T], [S], [T, S]])
@pytest.mark.parametrize("gap_s", [0.3, 1.0, 1.9])
def test_a_channel_that_was_cut_goes_on_from_its_first_sample_behind(cut: list[str], gap_s: float) -> None:
    intake = Intake(SMALL)
    missing = {(topic, time_s) for topic in cut for time_s in steps(5, 5 + gap_s)}
    feed = [
        reading(topic, time_s, time_s)
        for time_s in steps(0, 10)
        for topic in (T, S)
        if (topic, time_s) not in missing
    ]
    given = ticks(feed, intake)
    assert [tick.number for tick in given] == list(range(1000))
    assert [refused(intake, topic) for topic in (T, S)] == [{}, {}]
    behind = [tick for tick in given if tick.number >= round((5 + gap_s) * 100)]
    assert {tick.reasons for tick in behind} == {Reason(0)}
    assert behind[0].motor_torque == behind[0].motor_speed == 5 + gap_s


def test_a_clock_that_was_set_ahead_by_a_second_is_followed() -> None:
    intake = Intake(SMALL)
    given = ticks([*both(steps(0, 5)), *both(steps(6, 8))], intake)
    assert [tick.number for tick in given] == list(range(800))
    assert [refused(intake, topic) for topic in (T, S)] == [{}, {}]


@pytest.mark.parametrize("rate", [0.6, 1.0, 3.0])
def test_slow_channels_wait_for_nothing(rate: float) -> None:
    """Each comes more than `max_gap` behind the one before, and when it is due."""
    intake = Intake(SMALL)
    for time_s in steps(0, 10, rate):
        ticks(both([time_s]), intake)
        assert [channel.waiting for channel in intake.channels.values()] == [None, None]
        assert intake.channels[S].counts.accepted == intake.channels[S].counts.received


def test_a_lone_sample_behind_a_silence_is_not_believed_before_the_next() -> None:
    intake = Intake(SMALL)
    before = ticks([*both(steps(0, 5)), *one(T, steps(5, 60))], intake)
    lone = ticks([reading(S, 60, 20.0), *one(T, steps(60, 61))], intake)
    assert {tick.motor_speed for tick in [*before, *lone]} == {1.0}
    back = ticks([reading(S, 61.0, 20.0), reading(S, 61.01, 20.0), *both(steps(61.02, 62), 20.0)], intake)
    assert back[-1].motor_speed == 20.0
    assert refused(intake, S) == {}


def test_the_last_of_a_record_behind_a_gap_is_left_waiting() -> None:
    intake = Intake(SMALL)
    assert len(ticks([*both(steps(0, 1)), *both([1.5])], intake)) == 100
    for topic in (T, S):
        assert intake.channels[topic].waiting is not None
        assert refused(intake, topic) == {}


def test_one_that_waits_comes_twice_and_is_counted_as_doubled() -> None:
    intake = Intake(SMALL)
    ticks([*both(steps(0, 1)), reading(S, 1.5), reading(S, 1.5)], intake)
    assert refused(intake, S) == {"doubled": 1}


def test_one_that_waits_when_all_begins_anew_is_refused() -> None:
    intake = Intake(SMALL)
    ticks([*both(steps(0, 1)), reading(S, 1.5), *both(steps(100, 101))], intake)
    assert intake.restarts == 1
    assert refused(intake, S)["jumped"] >= 1
    assert intake.channels[S].waiting is None


def test_late_samples_say_nothing_of_one_that_waits() -> None:
    """Those from before the gap that come behind the first after it, over another way."""
    intake = Intake(SMALL)
    feed: Feed = [*both(steps(0, 1)), reading(S, 1.5), reading(S, 0.5), *one(S, steps(1.51, 2))]
    ticks([*feed, *one(T, steps(1, 2))], intake)
    assert refused(intake, S) == {"late": 1}


def test_at_the_edge_of_what_begins_anew_a_cut_of_both_is_still_bridged() -> None:
    intake = Intake(SMALL)
    given: list[Input] = ticks([*both(steps(0, 1)), *both(steps(0.99 + RESTART_GAP, 4))], intake)
    assert intake.restarts == 0
    assert [tick.number for tick in given] == list(range(400))
