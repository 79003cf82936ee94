"""The tick's grid, and nanoseconds as seconds: exact to the last bit, however far."""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vsensor.grid import NS, Grid, seconds

rates = st.one_of(
    st.floats(1, 5000), st.integers(1, 5000).map(float), st.sampled_from([30000 / 1001, 100 / 3])
)


@given(rates, st.integers(0, 10**9), st.integers(-(10**9), 2 * 10**9))
def test_ticks_at_once_are_the_ticks_one_by_one(rate: float, first: int, reach_ns: int) -> None:
    grid = Grid(rate)
    last_ns = grid.after_ns(first) + reach_ns
    expected: list[int] = []
    while (time_ns := grid.after_ns(first + len(expected))) <= last_ns:
        expected.append(time_ns)
    assert grid.until_ns(first, last_ns).tolist() == expected


@given(rates, st.integers(0, 10**12))
def test_a_tick_is_never_a_nanosecond_from_its_place(rate: float, number: int) -> None:
    exact = number * NS / Fraction(rate).limit_denominator(10**6)
    assert 0 <= exact - Grid(rate).after_ns(number) < 1


@given(st.lists(st.integers(-(1 << 62), 1 << 62), max_size=50))
def test_seconds_are_the_doubles_nearest_to_the_nanoseconds(times_ns: list[int]) -> None:
    assert seconds(np.array(times_ns, np.int64)).tolist() == [time_ns / NS for time_ns in times_ns]
