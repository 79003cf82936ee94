"""An allowance lets through what was promised, and no more."""

from itertools import accumulate

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.bus.allowance import Allowance
from vsensor.grid import NS

steps = st.lists(st.integers(0, NS // 10), min_size=1, max_size=300)


@given(st.integers(1, 1000), st.integers(1, 50), steps)
def test_no_span_of_time_holds_more_than_rate_and_burst(rate: int, burst: int, waits: list[int]) -> None:
    allowance = Allowance(rate, burst)
    passed = [now for now in accumulate(waits) if allowance.take(now)]
    for first, begun in enumerate(passed):
        for last in range(first, len(passed)):
            assert last - first + 1 <= burst + rate * (passed[last] - begun) / NS + 1e-3


@given(st.integers(1, 1000), st.integers(1, 50))
def test_a_burst_passes_whole_and_the_next_one_once_the_bucket_is_full(rate: int, burst: int) -> None:
    allowance = Allowance(rate, burst)
    assert [allowance.take(NS) for _ in range(burst + 1)] == [True] * burst + [False]
    later = NS + burst * NS // rate + 1
    assert [allowance.take(later) for _ in range(burst + 1)] == [True] * burst + [False]


@given(st.integers(1, 1000))
def test_what_keeps_to_the_rate_always_passes(rate: int) -> None:
    allowance = Allowance(rate, 1)
    assert all(allowance.take(-(-number * NS // rate)) for number in range(1, 300))


@pytest.mark.parametrize("rate", [1.0, 20e3])
def test_what_is_refused_costs_nothing_of_what_comes_after(rate: float) -> None:
    allowance = Allowance(rate, 1)
    now = NS
    assert allowance.take(now)
    assert not any(allowance.take(now + k) for k in range(1000))
    assert allowance.take(now + round(NS / rate) + 1)
