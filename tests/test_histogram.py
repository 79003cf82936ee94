"""Durations in buckets: none lost, and quantiles as near as the buckets are fine."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.grid import NS
from vsensor.service.histogram import UPPERS_NS, Histogram, quantile_s

durations = st.lists(st.integers(0, 30 * NS), min_size=1, max_size=200)


def counted(values: list[int]) -> Histogram:
    histogram = Histogram()
    for value in values:
        histogram.note(value)
    return histogram


@given(durations)
def test_each_duration_is_in_the_bucket_whose_bounds_hold_it(values: list[int]) -> None:
    plain = np.bincount(np.searchsorted(UPPERS_NS, values, side="right"), minlength=len(UPPERS_NS) + 1)
    told = counted(values).message()
    assert list(told.counts) == plain.tolist()
    assert told.sum_s == pytest.approx(sum(values) / NS)
    assert len(told.upper_s) == len(told.counts) - 1


def test_bounds_ascend_from_a_microsecond_to_seconds_by_a_quarter_at_most() -> None:
    steps = np.divide(UPPERS_NS[1:], UPPERS_NS[:-1])
    assert steps.min() > 1.1
    assert steps.max() == 1.25
    assert UPPERS_NS[0] == 1024
    assert UPPERS_NS[-1] > 17 * NS


@given(st.lists(st.integers(1024, 17 * NS), min_size=1, max_size=200), st.sampled_from([0.5, 0.9, 0.99, 1.0]))
def test_a_quantile_is_that_of_the_values_to_within_a_bucket(values: list[int], share: float) -> None:
    exact = np.quantile(values, share, method="inverted_cdf") / NS
    told = quantile_s(counted(values).counts, share)
    assert exact / 1.25 <= told <= exact * 1.25


def test_what_was_counted_since_is_told_apart() -> None:
    histogram = counted([2_000, 3_000_000])
    assert sum(histogram.turn_over()) == 2
    assert sum(histogram.turn_over()) == 0
    histogram.note(5_000)
    since = histogram.turn_over()
    assert sum(since) == 1
    assert 4e-6 < quantile_s(since, 0.5) <= 5.12e-6
    assert sum(histogram.counts) == 3


def test_of_nothing_there_is_no_quantile() -> None:
    with pytest.raises(ValueError, match="nothing was counted"):
        quantile_s(Histogram().counts, 0.5)
