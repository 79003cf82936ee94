"""The intake's books: each sample received is accepted or refused for one reason, each loss is counted."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.strings import PIPE, rig
from tests.test_intake import BEGUN, MS, SMALL, S, T, both, reading, steps, ticks
from vsensor.grid import NS
from vsensor.intake import Input, Intake
from vsensor.messages import ChannelStatus, Sample
from vsensor.messages.books import REFUSALS, refused
from vsensor.messages.vsensor_pb2 import BAD, UNCERTAIN
from vsensor.quality import Reason

DEEDS = (
    "plain", "plain", "plain", "plain", "silence", "late", "doubled", "nan", "inf", "far", "unreadable",
    "forward", "backward", "ahead", "absurd", "hole", "restart", "bad", "uncertain", "unnumbered",
    "wild",
)  # fmt: skip
Fed = list[tuple[str, Sample | None]]


class Source:
    """One channel of a rig that does whatever it is told, seldom what is right."""

    def __init__(self) -> None:
        self.time_ns = BEGUN
        self.sequence = 0
        self.last: Sample | None = None

    def do(self, deed: str, size: float) -> Sample | None:
        if deed == "unreadable":
            return None
        if deed == "doubled" and self.last is not None:
            return self.last
        leaps = {"silence": 5 * size, "forward": 1e6 * size, "backward": -1e6 * size, "late": -0.2 * size}
        self.time_ns += 10 * MS + round(leaps.get(deed, 0.0) * NS)
        self.sequence = 0 if deed == "restart" else self.sequence + 1 + round(9 * size) * (deed == "hole")
        values = {"nan": math.nan, "inf": math.copysign(math.inf, size - 0.5), "far": 1e7, "wild": -4e4}
        sample = Sample(time_ns=self.time_ns, value=values.get(deed, 50 * size), sequence=self.sequence)
        if deed == "ahead":
            sample.time_ns += round(2 * size * NS)
        if deed == "absurd":
            sample.time_ns = round((size - 0.5) * 2**63.9)
            sample.sequence = round(size * (2**64 - 2048))
        if deed in ("bad", "uncertain"):
            sample.quality = BAD if deed == "bad" else UNCERTAIN
        if deed == "unnumbered":
            sample.ClearField("sequence")
        self.last = sample
        return sample


@st.composite
def feeds(draw: st.DrawFn) -> Fed:
    deeds = st.tuples(st.sampled_from((T, S)), st.sampled_from(DEEDS), st.floats(0, 1), st.integers(1, 30))
    sources = {T: Source(), S: Source()}
    fed: Fed = []
    for topic, deed, size, quiet in draw(st.lists(deeds, max_size=60)):
        fed.append((topic, sources[topic].do(deed, size)))
        # Mostly both speak in turn; else hardly a tick would come of it.
        fed.extend((each, sources[each].do("plain", size)) for _ in range(quiet) for each in (T, S))
    return fed


def run(intake: Intake, fed: Fed) -> list[Input]:
    return [tick for topic, sample in fed for tick in intake.take(topic, sample)]


@given(feeds())
def test_the_books_balance(fed: Fed) -> None:
    intake = Intake(SMALL)
    run(intake, fed)
    for topic, channel in intake.channels.items():
        counts = channel.counts
        assert counts.received == sum(1 for to, _ in fed if to == topic)
        assert counts.received == counts.accepted + refused(counts) + (channel.waiting is not None)


@given(feeds(), st.sampled_from([60.0, 100.0, 300.0]))
def test_ticks_are_finite_and_on_an_exact_grid_whatever_comes_in(fed: Fed, rate: float) -> None:
    intake = Intake(rig(PIPE, rate=rate))
    runs: list[list[Input]] = []
    for tick in run(intake, fed):
        if tick.number == 0:
            runs.append([])
        runs[-1].append(tick)

    assert len(runs) <= intake.restarts + 1
    for given_out in runs:
        anchor = given_out[0].time_ns
        for k, tick in enumerate(given_out):
            assert tick.number == k
            assert tick.time_ns == anchor + k * NS // round(rate)
            assert math.isfinite(tick.motor_torque)
            assert math.isfinite(tick.motor_speed)


@given(feeds())
def test_the_same_samples_give_the_same_ticks_and_books(fed: Fed) -> None:
    one, other = Intake(SMALL), Intake(SMALL)
    assert run(one, fed) == run(other, fed)
    assert [c.counts for c in one.channels.values()] == [c.counts for c in other.channels.values()]


@given(feeds())
def test_no_channel_keeps_points_that_no_tick_can_need(fed: Fed) -> None:
    intake = Intake(SMALL)
    run(intake, fed)
    for channel in intake.channels.values():
        times = [point.time_ns for point in channel.points]
        assert all(a < b for a, b in pairwise(times))
        # Both gaps of time, and what the other channel may have got ahead by.
        assert not times or times[-1] - times[min(1, len(times) - 1)] <= 4.1 * NS


@pytest.mark.parametrize(
    ("sample", "reason"),
    [
        (Sample(value=math.nan), "not_finite"),
        (Sample(value=-math.inf), "not_finite"),
        (Sample(value=200_001), "out_of_range"),
        (Sample(value=-200_001), "out_of_range"),
        (Sample(value=1, quality=BAD), "bad_at_source"),
        (None, "unreadable"),
    ],
)
def test_what_cannot_be_believed_is_refused_for_its_reason(sample: Sample | None, reason: str) -> None:
    intake = Intake(SMALL)
    ticks(both(steps(0, 1)), intake)
    if sample is not None:
        sample.time_ns = BEGUN + NS
    assert intake.take(T, sample) == []
    assert refusals(intake) == {reason: 1}
    # A better one for the same time is welcome: nothing was kept of the other.
    assert len(ticks(both([1.0]), intake)) == 1


def test_limits_hold_at_the_motors_side_of_the_gear() -> None:
    geared = Intake(rig(PIPE, top_drive={"gear_ratio": 8.0}, measurement={"speed_limit": 30.0}))
    limits = [-240.1, -239.9, -239.9, 239.9, 239.9, 240.1]
    ticks([reading(S, k / 100, value) for k, value in enumerate(limits)], geared)
    assert geared.channels[S].counts.accepted == 4
    assert geared.channels[S].counts.out_of_range == 2


def test_what_the_source_calls_uncertain_is_used_and_flagged_where_it_takes_part() -> None:
    feed = list(both(steps(0, 0.05)))
    feed[4][1].quality = UNCERTAIN  # torque at 0.02 s, on the grid
    assert [tick.reasons for tick in ticks(feed)] == [0, 0, Reason.SOURCE_UNCERTAIN, 0, 0]


def test_what_is_uncertain_stays_so_between_samples_and_while_it_is_held() -> None:
    feed = list(both([0.0, 0.015, 0.035]))
    feed[2][1].quality = UNCERTAIN  # torque at 0.015 s, with ticks at 0.01, 0.02 and 0.03 s
    assert [tick.reasons for tick in ticks(feed)] == [0, *[Reason.SOURCE_UNCERTAIN] * 3]

    held = list(both([0.0]))
    held[0][1].quality = UNCERTAIN
    told = ticks([*held, *(reading(S, time_s) for time_s in steps(0.01, 1))])
    assert {tick.reasons for tick in told[1:]} == {Reason.SOURCE_UNCERTAIN | Reason.STALE_TORQUE}


def test_doubled_and_late_samples_are_refused_and_told_apart() -> None:
    intake = Intake(SMALL)
    ticks(both(steps(0, 1)), intake)
    before = intake.take(T, reading(T, 0.99, 5.0)[1])
    assert (before, refusals(intake)) == ([], {"doubled": 1})
    intake.take(T, reading(T, 0.5, 5.0)[1])
    assert refusals(intake) == {"doubled": 1, "late": 1}


def refusals(intake: Intake, topic: str = T) -> dict[str, int]:
    counts = intake.channels[topic].counts
    return {reason: count for reason in REFUSALS if (count := getattr(counts, reason))}


def numbered(*given: int, at: list[float] | None = None) -> ChannelStatus:
    """The books of a channel whose samples bear these sequence numbers."""
    intake = Intake(SMALL)
    intake.take(S, reading(S, 0)[1])
    for k, sequence in enumerate(given):
        time_s = at[k] if at else k / 100
        intake.take(T, Sample(time_ns=BEGUN + round(time_s * NS), value=1.0, sequence=sequence))
        intake.take(S, reading(S, time_s)[1])
    return intake.channels[T].counts


def test_a_hole_in_the_sequence_is_a_loss() -> None:
    assert numbered(7, 8, 9, 13, 14).lost == 3


def test_a_missing_sample_that_comes_late_is_no_loss_even_if_no_tick_can_use_it() -> None:
    assert numbered(0, 1, 5, 3, 6, at=[0, 0.01, 0.05, 0.03, 0.06]).lost == 2
    # Further holes since then make no difference.
    assert numbered(0, 1, *range(3, 30), 31, 2, at=[k / 100 for k in range(31)]).lost == 1
    assert numbered(0, 1, 3, 3, 2, at=[0, 0.01, 0.03, 0.03, 0.02]).lost == 0  # nor one that came twice
    late = numbered(0, 1, 3, 2, 4, at=[0, 0.01, 0.03, 0.02, 0.04])
    assert (late.lost, late.late) == (0, 1)


def test_a_sample_that_comes_twice_does_not_make_up_for_another_that_is_lost() -> None:
    """However old it is: the grid has long let go of its time."""
    books = numbered(0, 1, 2, 3, 4, 9, 2, 2, at=[0, 0.01, 0.02, 0.03, 0.04, 0.09, 0.02, 0.02])
    assert books.lost == 4


def test_refused_samples_are_not_lost_ones() -> None:
    intake = Intake(SMALL)
    for k in range(10):
        value = math.nan if k % 2 else 1e9
        intake.take(T, Sample(time_ns=BEGUN + k * 10 * MS, value=value, sequence=k))
    assert intake.channels[T].counts.lost == 0


def test_a_publisher_that_starts_again_from_0_has_lost_nothing() -> None:
    assert numbered(500, 501, 502, 0, 1, 2).lost == 0
    assert numbered(500, 505, 0, 1, 3).lost == 5
    # Nor do its low numbers make up for those that were lost before.
    assert numbered(0, 1, 2, 5, 0, 1, 2, 3, 4).lost == 2


@pytest.mark.parametrize("jump_s", [-3600.0, 3600.0])
def test_nor_has_one_that_starts_again_with_its_clock_set(jump_s: float) -> None:
    times = [0, 0.01, 0.06, *(jump_s + k / 100 for k in range(5))]
    assert numbered(500, 501, 506, 0, 1, 2, 3, 4, at=times).lost == 4
    assert numbered(500, 501, 506, 507, 508, 509, 510, 512, at=times).lost == 5


def test_what_was_sent_during_a_long_cut_is_lost_once() -> None:
    assert numbered(0, 1, 1000, 1001, 1002, at=[0, 0.01, 60, 60.01, 60.02]).lost == 998


def test_a_wild_sequence_number_is_another_publishers_and_no_loss() -> None:
    """Else the count would soon pass 64 bits, which ends the loop."""
    assert numbered(*[5, 2**64 - 1] * 3, 5, 7).lost == 1


@given(st.lists(st.sampled_from(["read", "unread", "gone"]), max_size=60))
def test_what_came_too_fast_is_refused_and_not_lost_as_well(fates: list[str]) -> None:
    """The books balance: published = accepted + refused + lost."""
    intake = Intake(SMALL)
    published = ["read", *fates, "read"]
    for number, fate in enumerate(published):
        if fate == "unread":
            intake.refuse_unread(T)
        elif fate == "read":
            intake.take(T, Sample(time_ns=BEGUN + number * MS, value=1.0, sequence=number))
    counts = intake.channels[T].counts
    assert counts.over_rate == fates.count("unread")
    assert counts.received == counts.accepted + refused(counts)
    assert len(published) == counts.accepted + refused(counts) + counts.lost
