"""The report's plots: what stands out is drawn, every tick counts, and more of them take no more memory."""

import math
import tracemalloc
from base64 import b64decode
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.reported import pieces, ticks
from vsensor.report.again import Lateness, Portrait
from vsensor.report.figures import Extent
from vsensor.report.grown import Grown
from vsensor.report.plots import portrait
from vsensor.report.thin import Thinned
from vsensor.report.ticks import BIT, BIT_TORQUE, Ticks
from vsensor.units import factor

values = st.floats(-1e6, 1e6) | st.just(math.nan)


@given(st.lists(st.lists(values, max_size=200), min_size=1, max_size=6), st.integers(1, 40))
def test_every_stretch_keeps_its_least_and_greatest(told: list[list[float]], bins: int) -> None:
    series = np.array([value for piece in told for value in piece])
    thinned, begin = Thinned(2, bins), 0
    for piece in told:
        end = begin + len(piece)
        thinned.add(np.arange(begin, end), np.array(piece), -np.array(piece))
        begin = end
    time, (thin, negative) = thinned.drawn()
    assert negative.tobytes() == (-thin).tobytes()
    if len(series) <= 2 * bins:
        assert thin.tobytes() == series.tobytes()
        assert time.tolist() == list(range(len(series)))
        return
    stretches = len(thin) // 2
    assert bins <= stretches <= 2 * bins
    firsts = [*time[::2].tolist(), len(series)]
    for k, (start, stop) in enumerate(pairwise(firsts)):
        assert time[2 * k + 1] == stop - 1
        stretch = series[start:stop]
        known = stretch[np.isfinite(stretch)]
        pair = thin[2 * k : 2 * k + 2]
        if len(known):
            assert (np.nanmin(pair), np.nanmax(pair)) == (known.min(), known.max())
        else:
            assert np.isnan(pair).all()
    assert len(set(np.diff(firsts[:-1]).tolist())) <= 1  # all as wide, but for the last


def test_of_a_stretch_what_came_first_is_drawn_first() -> None:
    thinned = Thinned(1, bins=1)
    thinned.add(np.arange(8), np.array([0.0, 5.0, 1.0, 2.0, 9.0, 3.0, 4.0, 4.0]))
    assert thinned.drawn()[1].tolist() == [[0.0, 5.0, 9.0, 3.0]]


def test_however_much_is_drawn_it_takes_no_more_memory() -> None:
    def peak(count: int) -> int:
        piece = np.zeros(2000)
        tracemalloc.start()
        thinned = Thinned(2)
        for begin in range(0, count, len(piece)):
            thinned.add(begin + np.arange(len(piece)), piece, piece)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    assert peak(800_000) < 1.1 * peak(80_000)


@given(st.lists(st.lists(st.floats(), max_size=50), max_size=30))
def test_a_column_grown_piece_by_piece_is_all_of_them(pieces: list[list[float]]) -> None:
    column = Grown(np.float64)
    for piece in pieces:
        column.add(np.array(piece))
    together = np.array([value for piece in pieces for value in piece])
    assert len(column) == len(together)
    assert column.whole().tobytes() == together.tobytes()


def test_a_column_takes_little_more_memory_than_its_numbers() -> None:
    """Nor does the growing: an eighth more than there is, and one piece."""
    piece = np.zeros(10_000)
    tracemalloc.start()
    column = Grown(np.float64)
    for _ in range(200):
        column.add(piece)
    size = column.whole().nbytes
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert size == 200 * piece.nbytes
    assert most < 1.2 * size


def portrait_of(told: Ticks, cuts: list[int]) -> Portrait:
    speed, torque = Extent(), Extent()
    speed.add(told[BIT])
    torque.add(told[BIT_TORQUE])
    counted = Portrait(speed, torque)
    for piece in pieces(told, cuts):
        counted.add(piece)
    return counted


@pytest.mark.parametrize("count", [0, 1, 7, 350])
def test_the_portrait_counts_every_tick_however_many_at_a_time(count: int) -> None:
    bit = 10 + 5 * np.sin(np.arange(count + 1.0))
    bit[-1] = np.nan
    drawn = portrait(portrait_of(ticks(bit), [3, 100, 200]), None)
    assert drawn == portrait(portrait_of(ticks(bit), []), None)
    counted = [10**shade for row in drawn["data"][0]["z"] for shade in row if shade is not None]
    assert sum(counted) == pytest.approx(count, rel=0.01)


def test_the_law_is_drawn_as_far_as_the_bit_ran() -> None:
    told = ticks(10 + 15 * np.sin(np.arange(350.0)))
    law = portrait(portrait_of(told, []), (50.0, 4000.0, 9000.0, 3.0))["data"][1]
    speed = np.frombuffer(b64decode(law["x"]["bdata"]))
    assert speed.max() == pytest.approx(told[BIT].max() * factor("rad/s", "rpm"))


def test_every_tick_is_late_by_some_bin() -> None:
    late = np.array([-1e-4, 0.0, 2e-6, 5e-4, np.nan, 0.03])
    counted = Lateness(0.03)
    counted.add(late[:3])
    counted.add(late[3:])
    assert counted.edges_ms[0] == 1e-3
    assert counted.edges_ms[-2] < 30 <= counted.edges_ms[-1]
    assert np.diff(np.log10(counted.edges_ms)) == pytest.approx(1 / 15)
    assert counted.counts.sum() == 5
    assert counted.counts[0] == 2
    of_a_quick_loop = Lateness(1e-5).edges_ms
    assert len(of_a_quick_loop) == 61
    assert of_a_quick_loop[-1] == pytest.approx(10.0)
