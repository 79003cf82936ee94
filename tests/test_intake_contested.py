"""Two publishers on one rig: never good while it lasts, and nothing that either told is a loss."""

from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.test_arrivals import as_one_by_one
from tests.test_intake import BEGUN, MS, SMALL, S, T, ticks
from vsensor.intake import Intake, stretch
from vsensor.intake.sequence import QUIET, TURNS
from vsensor.messages import Sample
from vsensor.quality import Quality, Reason, verdict

BOTH_STALE = Reason.STALE_TORQUE | Reason.STALE_SPEED
Fed = list[tuple[str, Sample]]


def told(
    numbers: range, begun_ms: int, first: int, every_ms: int = 10, topics: tuple[str, ...] = (T, S)
) -> Fed:
    """Some of a publisher's samples: `first` is its number at `begun_ms`."""
    return [
        (
            topic,
            Sample(
                time_ns=BEGUN + (begun_ms + k * every_ms) * MS,
                value=(first + k) * 37 % 101 / 700,
                sequence=first + k,
            ),
        )
        for k in numbers
        for topic in topics
    ]


def mixed(*publishers: Fed) -> Fed:
    return sorted(chain(*publishers), key=lambda each: each[1].time_ns)


@pytest.mark.parametrize("other", [2_000, 9_900, 10_400, 13_000, 900_000, 5_000_000])
def test_two_publishers_are_never_good_and_have_lost_nothing(other: int) -> None:
    """Whichever counts higher: one alone, then both for ten seconds, then one again."""
    intake = Intake(SMALL)
    given_out = ticks(mixed(told(range(3000), 0, 10_000), told(range(1000), 10_005, other)), intake)
    assert {tick.reasons for tick in given_out[:1000]} == {0}
    assert {verdict(tick.reasons) for tick in given_out[1005:2000]} == {Quality.BAD}
    assert {tick.reasons for tick in given_out[2000 + QUIET + 10 :]} == {0}
    for channel in intake.channels.values():
        assert channel.counts.lost <= 1
        assert not channel.sequence.contested


def test_which_channels_two_tell_is_known_while_they_do() -> None:
    intake = Intake(SMALL)
    both = mixed(told(range(1000), 0, 10_000), told(range(500), 5, 2_000, topics=(S,)))
    ticks(both[: 2 * 20], intake)
    assert intake.contested == (S,)
    given_out = ticks(both[2 * 20 :], intake)
    assert {tick.reasons for tick in given_out[50:400]} == {Reason.STALE_SPEED}
    assert not intake.contested


def test_a_second_publisher_that_is_slow_is_told_too() -> None:
    """At 2 Hz beside 100."""
    intake = Intake(SMALL)
    given_out = ticks(mixed(told(range(3000), 0, 10_000), told(range(60), 3, 2_000, every_ms=500)), intake)
    assert {tick.reasons for tick in given_out[300:]} == {BOTH_STALE}
    assert [channel.counts.lost for channel in intake.channels.values()] == [0, 0]


def test_one_that_starts_again_or_loses_much_is_no_second_publisher() -> None:
    restarts = [told(range(300), 3000 * k, 0) for k in range(9)]
    crashes = [told(range(20), 200 * k, 0) for k in range(9)]
    losses = [told(range(300), 3000 * k, 5000 * k) for k in range(9)]
    for runs, lost in ((restarts, 0), (crashes, 0), (losses, 8 * 4700)):
        intake = Intake(SMALL)
        given_out = ticks(chain(*runs), intake)
        assert {tick.reasons for tick in given_out} == {0}
        assert [channel.counts.lost for channel in intake.channels.values()] == [lost, lost]


def test_a_long_backlog_that_comes_late_is_no_second_publisher() -> None:
    fed = told(range(3000), 0, 0)
    intake = Intake(SMALL)
    ticks([*fed[:1000], *fed[4000:5000], *fed[1000:1200], *fed[5000:]], intake)
    assert not intake.contested
    assert not any(channel.sequence.contested for channel in intake.channels.values())


@given(
    st.lists(
        st.tuples(st.sampled_from([0, 1]), st.integers(1, 30), st.sampled_from([0, 0, 0, 1, 40])), max_size=14
    ),
    st.sampled_from([0, 300, 3_000, 5_000_000]),
    st.sampled_from([3, 50, 10_000]),
    st.integers(0, 300),
)
def test_by_columns_and_gone_on_with_it_is_the_same(
    turns: list[tuple[int, int, int]], apart: int, cut: int, split: int
) -> None:
    due, fed, at_ms = [1000, 1000 + apart], told(range(20), 0, 980), 200
    for which, count, missing in turns:
        due[which] += missing
        fed += told(range(count), at_ms, due[which])
        due[which] += count
        at_ms += 10 * count
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stretch, "FEWEST", 4)
        patch.setattr("vsensor.intake.sequence.QUIET", 25)
        as_one_by_one(SMALL, fed, cut, split)


def test_a_damaged_memory_of_two_counts_is_refused() -> None:
    for value, said in (
        ([None, 0, 0], r"counts holds .* where a list of 4"),
        ([-1, 0, 0, 0], r"counts\[0\] holds -1 where"),
        ([None, 0, TURNS + 1, 0], r"counts\[2\] holds .* where a whole number from 0 to 3"),
    ):
        saved = Intake(SMALL).save()
        saved["channels"][T]["counts"] = value
        with pytest.raises(ValueError, match=said):
            Intake(SMALL).restore(saved)
