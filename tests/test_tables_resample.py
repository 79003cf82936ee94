"""Tables on a regular grid: straight lines between rows, nothing in a hole, however the rows are cut."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.errors import ConfigError
from vsensor.messages import SURFACE_BIT_DEPTH
from vsensor.tables import SurfaceTable
from vsensor.tables.resample import resampled

MS = 1_000_000


def table(times_ms: list[int]) -> SurfaceTable:
    """Torque 2 N·m a ms from 0 on, speed the opposite: what lies on a line stays on it."""
    times = np.array(times_ms, np.int64)
    torque = 2.0 * times.astype(np.float64)
    return SurfaceTable(times * MS, torque, -torque)


def cut(whole: SurfaceTable, rows: int) -> Iterator[SurfaceTable]:
    for start in range(0, len(whole), rows):
        part = slice(start, start + rows)
        yield SurfaceTable(whole.time_ns[part], whole.motor_torque_nm[part], whole.motor_speed_rad_s[part])


@given(st.lists(st.integers(8, 14), min_size=3, max_size=60), st.integers(2, 70))
def test_a_line_stays_a_line_however_it_is_cut(steps: list[int], rows: int) -> None:
    whole = table(np.cumsum(steps).tolist())
    pieces = list(resampled(cut(whole, rows), "100 Hz"))
    times = np.concatenate([piece.time_ns for piece in pieces])
    assert times.tolist() == list(range(int(whole.time_ns[0]), int(whole.time_ns[-1]) + 1, 10 * MS))
    np.testing.assert_allclose(
        np.concatenate([p.motor_torque_nm for p in pieces]), times / MS * 2.0, atol=1e-9
    )
    np.testing.assert_allclose(
        np.concatenate([p.motor_speed_rad_s for p in pieces]), times / MS * -2.0, atol=1e-9
    )


@given(st.lists(st.booleans(), min_size=9, max_size=90), st.integers(8, 100))
def test_each_depth_is_told_once_as_soon_as_there_is_a_row(known: list[bool], rows: int) -> None:
    """Of rows at 100 Hz on a grid of 40: one that was told between two may not be lost."""
    depth = np.where(known, np.arange(len(known)) + 1000.0, np.nan)
    times = 10 * np.arange(len(known))
    whole = table(times.tolist())
    parts = (slice(start, start + rows) for start in range(0, len(whole), rows))
    pieces = (
        SurfaceTable(
            whole.time_ns[part],
            whole.motor_torque_nm[part],
            whole.motor_speed_rad_s[part],
            {SURFACE_BIT_DEPTH: depth[part]},
        )
        for part in parts
    )
    laid = [piece for piece in resampled(pieces, "40 Hz") if len(piece)]
    told = np.concatenate([piece.depths_m[SURFACE_BIT_DEPTH] for piece in laid])
    at = np.concatenate([piece.time_ns for piece in laid])[np.isfinite(told)] / MS
    found = told[np.isfinite(told)]
    assert np.all(np.diff(found) > 0)
    assert np.all(np.abs(at - 10 * (found - 1000)) < 25)
    for time in times[known]:
        assert time > laid[-1].time_ns[-1] / MS or np.abs(at - time).min() < 25


def test_nothing_is_made_up_in_a_hole() -> None:
    (piece,) = resampled(iter([table([0, 10, 20, 30, 500, 510, 520])]), "200 Hz")
    assert (piece.time_ns // MS).tolist() == [0, 5, 10, 15, 20, 25, 30, 500, 505, 510, 515, 520]


@pytest.mark.parametrize("rate", ["10 rpm", "0 Hz", "-5 Hz", "10 MHz", "often"])
def test_what_is_no_rate_is_wrong_use(rate: str) -> None:
    with pytest.raises(ConfigError, match="--resample: "):
        list(resampled(iter([table([0, 10])]), rate))
