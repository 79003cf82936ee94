"""Thinning for drawing: far fewer points, no peak and no hole lost."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vsensor.view.trace import HOLE_NS, SLOT_NS, Trace, envelope

MS = 1_000_000
VALUES = st.one_of(st.floats(-1e6, 1e6), st.just(math.nan))


def naive_envelope(times: list[int], values: list[float]) -> set[int]:
    """Row by row: the first lowest and the last highest of each slot, and every hole."""
    kept = {row for row, value in enumerate(values) if math.isnan(value)}
    for slot in {time // SLOT_NS for time in times}:
        rows = [r for r, t in enumerate(times) if t // SLOT_NS == slot and not math.isnan(values[r])]
        if rows:
            kept |= {min(rows, key=lambda r: (values[r], r)), max(rows, key=lambda r: (values[r], r))}
    return kept


@given(st.lists(st.tuples(st.integers(0, 300 * MS), VALUES), max_size=60))
def test_the_envelope_is_the_naive_one(rows: list[tuple[int, float]]) -> None:
    times, values = [t for t, _ in rows], [v for _, v in rows]
    kept = envelope(np.array(times, dtype=np.int64), np.array(values, dtype=np.float64))
    assert kept.tolist() == sorted(naive_envelope(times, values))


def test_a_kilohertz_is_drawn_by_a_hundred_points_a_second_and_the_one_late_tick_is_among_them() -> None:
    trace = Trace()
    for number in range(1000):
        trace.add(number * MS, 7.0 if number == 503 else 0.01 * math.sin(number))
    times, values = trace.take()
    assert len(times) == 100
    assert (times[values[:, 0].argmax()], values[:, 0].max()) == (503 * MS, 7.0)


def test_a_hundred_hertz_is_drawn_whole() -> None:
    trace = Trace()
    for number in range(100):
        trace.add(number * 10 * MS, float(number % 7), 0.5)
    times, values = trace.take()
    assert times.tolist() == [number * 10 * MS for number in range(100)]
    assert values.tolist() == [[number % 7, 0.5] for number in range(100)]


def test_what_was_taken_is_not_taken_again() -> None:
    trace = Trace()
    trace.add(1, 1.0)
    assert trace.take()[0].tolist() == [1]
    assert trace.take()[0].tolist() == []


def test_a_line_ends_once_where_nothing_is_known_and_goes_on_after() -> None:
    trace = Trace()
    for time_ns, value in (
        (0, math.nan),
        (100 * MS, 1.0),
        (200 * MS, math.nan),
        (300 * MS, math.inf),
        (400 * MS, 2.0),
    ):
        trace.add(time_ns, value)
    times, values = trace.take()
    assert times.tolist() == [100 * MS, 100 * MS + 1, 400 * MS]
    np.testing.assert_array_equal(values[:, 0], [1.0, math.nan, 2.0])


def test_rows_far_apart_are_not_joined() -> None:
    trace = Trace()
    trace.add(0, 1.0)
    trace.add(HOLE_NS, 2.0)
    trace.add(2 * HOLE_NS + 1, 3.0)
    times, values = trace.take()
    assert times.tolist() == [0, HOLE_NS, HOLE_NS + 1, 2 * HOLE_NS + 1]
    np.testing.assert_array_equal(values[:, 0], [1.0, 2.0, math.nan, 3.0])
