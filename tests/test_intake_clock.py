"""The source's clock, set by less than what begins anew of itself: what comes of it is not called good."""

import json
import math
from collections.abc import Callable, Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.test_arrivals import as_one_by_one
from tests.test_intake import BEGUN, MS, SMALL, S, T, ticks
from vsensor.grid import NS
from vsensor.intake import Intake, stretch
from vsensor.intake.clock import LATELY
from vsensor.messages import Sample
from vsensor.quality import Reason

Fed = list[tuple[str, Sample]]


def told(numbers: Iterable[int], shift_s: float = 0.0, rate: float = 100.0) -> Fed:
    """Both channels in turn, numbered, their clocks ahead by some time."""
    return [
        (topic, Sample(time_ns=BEGUN + round((k / rate + shift_s) * NS), value=k % 7 / 50, sequence=k))
        for k in numbers
        for topic in (T, S)
    ]


def unnumbered(fed: Fed) -> Fed:
    return [(topic, Sample(time_ns=sample.time_ns, value=sample.value)) for topic, sample in fed]


@pytest.mark.parametrize("back_s", [0.06, 0.1, 0.5, 1.5, 1.9])
@pytest.mark.parametrize("of", [list, unnumbered], ids=["numbered", "unnumbered"])
def test_a_clock_that_was_set_back_a_little_begins_anew(back_s: float, of: Callable[[Fed], Fed]) -> None:
    intake = Intake(SMALL)
    given_out = ticks(of([*told(range(500)), *told(range(500, 1000), -back_s)]), intake)
    assert intake.restarts == 1
    assert [tick.number for tick in given_out[:500]] == list(range(500))
    assert given_out[500].number == 0
    assert given_out[500].time_ns <= BEGUN + round((5.05 - back_s) * NS)
    assert len(given_out) >= 990


@pytest.mark.parametrize("ahead_s", [0.06, 0.1, 0.2])
def test_a_clock_that_was_set_ahead_a_little_is_flagged(ahead_s: float) -> None:
    """No number is missing, but time is."""
    intake = Intake(SMALL)
    given_out = ticks([*told(range(500)), *told(range(500, 1000), ahead_s)], intake)
    doubted = [tick.time_ns for tick in given_out if tick.reasons]
    assert {tick.reasons for tick in given_out} == {0, Reason.GAP_BRIDGED}
    assert doubted == [BEGUN + k * 10 * MS for k in range(500, 500 + round(ahead_s * 100))]
    assert [channel.counts.lost for channel in intake.channels.values()] == [0, 0]


def test_what_was_lost_or_refused_is_no_clock_that_was_set() -> None:
    lost = [*told(range(500)), *told(range(520, 1000))]
    refused = told(range(1000))
    for _, sample in refused[1000:1040]:
        sample.value = math.nan
    one_pauses = [each for each in told(range(1000)) if each[0] == S or not 500 <= each[1].sequence < 520]
    for _, sample in one_pauses:
        sample.ClearField("sequence")
    for fed in (lost, refused, one_pauses):
        intake = Intake(SMALL)
        given_out = ticks(fed, intake)
        assert [tick.number for tick in given_out] == list(range(1000))
        assert {tick.reasons for tick in given_out} == {0}


def test_one_channel_that_pauses_or_falls_behind_alone_is_no_clock_that_was_set() -> None:
    for shift_s in (0.2, -0.2):
        intake = Intake(SMALL)
        torque = [each for each in told(range(500, 1000), shift_s) if each[0] == T]
        speed = [each for each in told(range(500, 1000)) if each[0] == S]
        turns = [each for pair in zip(torque, speed, strict=True) for each in pair]
        given_out = ticks([*told(range(500)), *turns], intake)
        assert intake.restarts == 0
        assert not any(tick.reasons & Reason.GAP_BRIDGED for tick in given_out)


def test_samples_sent_again_or_out_of_order_are_no_clock_that_was_set() -> None:
    fed = told(range(1000))
    again = [*fed[:1000], *fed[800:1000], *fed[1000:]]
    late = [*fed[:800], *fed[900:1000], *fed[800:900], *fed[1000:]]
    swapped = unnumbered(
        [
            *fed[:800],
            *(each for k in range(800, 1000, 4) for each in fed[k + 2 : k + 4] + fed[k : k + 2]),
            *fed[1000:],
        ]
    )
    for sent in (again, late, swapped):
        intake = Intake(SMALL)
        given_out = ticks(sent, intake)
        assert [tick.number for tick in given_out] == list(range(1000))
        assert intake.restarts == 0


@pytest.mark.parametrize("rate", [10.0, 100.0, 2000.0])
def test_times_that_tremble_by_half_a_period_are_no_clock_that_was_set(rate: float) -> None:
    intake = Intake(SMALL)
    fed = told(range(4000), rate=rate)
    for k, (_, sample) in enumerate(fed):
        sample.time_ns += round((k * 7919 % 1000 / 1000 - 0.5) * NS / rate)
    given_out = ticks(fed, intake)
    assert intake.restarts == 0
    assert not any(tick.reasons for tick in given_out)


@given(
    st.lists(st.tuples(st.integers(1, 40), st.sampled_from([0, 0, 6, 12, -7, -30, 300])), max_size=6),
    st.sampled_from([3, 50, 10_000]),
    st.integers(0, 300),
)
def test_by_columns_and_gone_on_with_it_is_the_same(
    runs: list[tuple[int, int]], cut: int, split: int
) -> None:
    fed, number, shift = told(range(20)), 20, 0
    for count, more in runs:
        shift += more
        fed += told(range(number, number + count), shift / 100)
        number += count
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stretch, "FEWEST", 4)
        as_one_by_one(SMALL, fed, cut, split)


def test_a_damaged_memory_of_times_is_refused() -> None:
    for place, value, said in (
        ((0,), "now", r"clock\[0\] holds 'now' where"),
        ((1,), [1] * (LATELY + 1), r"clock\[1\] holds .* where a list of 32 at the most"),
        ((1,), [0], r"clock\[1\]\[0\] holds 0 where"),
        ((2,), [1], r"clock\[2\] holds \[1\] where a list of 2"),
        ((3, 0), -1, r"clock\[3\]\[0\] holds -1 where"),
    ):
        saved = json.loads(json.dumps(Intake(SMALL).save()))
        *way, last = place
        part = saved["channels"][T]["clock"]
        for key in way:
            part = part[key]
        part[last] = value
        with pytest.raises(ValueError, match=said):
            Intake(SMALL).restore(saved)
