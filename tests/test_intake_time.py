"""The source's clock: set, torn, strayed from. One stray time is refused, two begin anew."""

import pytest

from tests.test_intake import BEGUN, MS, SMALL, Feed, S, T, both, one, reading, steps, ticks
from vsensor.grid import NS
from vsensor.intake import Intake
from vsensor.messages import Sample

JUMPS = [3600.0, -3600.0, 10.0, -10.0, 1e8, -1e8]


def jumped(intake: Intake) -> int:
    return sum(channel.counts.jumped for channel in intake.channels.values())


@pytest.mark.parametrize("jump_s", JUMPS)
def test_one_stray_sample_is_refused(jump_s: float) -> None:
    intake = Intake(SMALL)
    feed = [*both(steps(0, 1)), reading(T, 1 + jump_s), *both(steps(1, 2))]
    given_out = ticks(feed, intake)

    assert [tick.number for tick in given_out] == list(range(200))
    assert {tick.reasons for tick in given_out} == {0}
    assert intake.channels[T].counts.jumped == 1
    assert intake.restarts == 0


@pytest.mark.parametrize("jump_s", JUMPS)
def test_so_is_each_that_follows_with_true_ones_between(jump_s: float) -> None:
    intake = Intake(SMALL)
    feed = [*both(steps(0, 1)), reading(T, 1 + jump_s), *both(steps(1, 1.5)), reading(T, 1.5 + jump_s)]
    assert [tick.number for tick in ticks([*feed, *both(steps(1.5, 2))], intake)] == list(range(200))
    assert (jumped(intake), intake.restarts) == (2, 0)


def test_a_refused_time_is_forgotten_once_the_clock_was_set() -> None:
    """Else a single stray, long after, would count as the second of two."""
    intake = Intake(SMALL)
    ticks([*both(steps(0, 5)), reading(S, 100), *one(T, steps(100, 200))], intake)
    assert (intake.restarts, jumped(intake)) == (1, 2)
    ticks([reading(S, 101)], intake)
    assert (intake.restarts, jumped(intake)) == (1, 3)


@pytest.mark.parametrize("jump_s", JUMPS)
@pytest.mark.parametrize("rate", [100.0, 1.0], ids=lambda rate: f"{rate:g} Hz")
def test_a_clock_that_was_set_begins_anew(jump_s: float, rate: float) -> None:
    """Whatever the rate of the samples: those of a slow rig lie further apart than `max_gap`."""
    intake = Intake(SMALL)
    ticks(both(steps(0, 5, rate)), intake)
    given_out = ticks(both(steps(5 + jump_s, 15 + jump_s, rate)), intake)

    assert intake.restarts == 1
    assert given_out[0].number == 0
    assert given_out[0].time_ns == BEGUN + round((5 + jump_s + 1 / rate) * NS)
    assert len(given_out) == pytest.approx(1000, abs=2 * 100 / rate)
    assert jumped(intake) in (1, 2)


@pytest.mark.parametrize("cut_s", [2.5, 60.0, 86_400.0])
@pytest.mark.parametrize("first", [T, S])
def test_after_a_long_cut_of_both_the_grid_is_laid_anew(cut_s: float, first: str) -> None:
    intake = Intake(SMALL)
    ticks(both(steps(0, 5)), intake)
    given_out = ticks([reading(first, 5 + cut_s), *both(steps(5.01 + cut_s, 8 + cut_s))], intake)

    assert intake.restarts == 1
    assert [tick.number for tick in given_out] == list(range(len(given_out)))
    assert {tick.reasons for tick in given_out} == {0}
    assert len(given_out) >= 297


def test_a_cut_of_both_that_is_short_is_bridged_without_restart() -> None:
    intake = Intake(SMALL)
    given_out = ticks([*both(steps(0, 1)), *both(steps(2.9, 4))], intake)
    assert [tick.number for tick in given_out] == list(range(400))
    assert intake.restarts == 0


def test_one_channels_cut_of_any_length_is_no_restart() -> None:
    intake = Intake(SMALL)
    feed: Feed = [*both(steps(0, 1)), *one(T, steps(1, 100)), *both(steps(100, 101))]
    assert [tick.number for tick in ticks(feed, intake)] == list(range(10_100))
    assert (intake.restarts, jumped(intake)) == (0, 0)


def test_old_samples_that_come_after_a_restart_are_refused_or_waited_out() -> None:
    """The other channel's backlog from before the clock was set: the grid settles all the same."""
    intake = Intake(SMALL)
    ticks(both(steps(0, 5)), intake)
    ticks([*one(T, [100.0, 100.01]), reading(S, 5.0)], intake)
    given_out = ticks(both(steps(100.02, 103)), intake)
    assert intake.restarts == 1
    assert [tick.number for tick in given_out] == list(range(298))

    more = [*one(T, [1000.0, 1000.01]), *one(S, steps(103, 103.5)), *both(steps(1000.02, 1010))]
    given_out = ticks(more, intake)
    assert given_out[-1].number > 900
    assert given_out[-1].reasons == 0


def test_a_stray_first_sample_of_a_channel_only_costs_a_restart() -> None:
    for stray_s in (1e9, -1e9):
        intake = Intake(SMALL)
        given_out = ticks([reading(T, stray_s), *both(steps(0, 10))], intake)
        assert len(given_out) >= 998
        assert [tick.number for tick in given_out] == list(range(len(given_out)))


def test_a_source_whose_clock_stands_still_never_makes_a_tick() -> None:
    intake = Intake(SMALL)
    ticks(both(steps(0, 1)), intake)
    assert ticks(both([500.0] * 100), intake) == []
    assert intake.restarts == 0


@pytest.mark.parametrize("time_ns", [-(2**63), -(2**62) - 100, 2**62 + 1, 2**63 - 100])
def test_a_time_so_far_off_that_messages_could_not_bear_its_answers_is_refused(time_ns: int) -> None:
    """Else the forecast's time would not fit its field, and the loop would end."""
    intake = Intake(SMALL)
    far = [(topic, Sample(time_ns=time_ns + k, value=1.0)) for k in range(99) for topic in (T, S)]
    assert ticks(far, intake) == []
    assert jumped(intake) == 198
    assert len(ticks(both(steps(0, 1)), intake)) == 100


def test_the_two_clocks_may_differ_by_less_than_the_restart_gap() -> None:
    intake = Intake(SMALL)
    feed = [pair for t in steps(0, 5) for pair in (reading(T, t + 1.5), reading(S, t))]
    given_out = ticks(feed, intake)
    assert given_out[0].time_ns == BEGUN + 1500 * MS
    assert intake.restarts == 0
