"""A surface table laid on a regular grid: straight lines between neighbours, and no gap filled."""

from collections.abc import Iterator

import numpy as np

from vsensor.errors import ConfigError
from vsensor.grid import NS, Grid
from vsensor.tables.cells import Floats
from vsensor.tables.course import Times
from vsensor.tables.surface import SurfaceTable
from vsensor.units import to_si

HOLE = 5.0
"""Neighbours so many times further apart than most of the rows have nothing between them."""


def resampled(pieces: Iterator[SurfaceTable], rate: str) -> Iterator[SurfaceTable]:
    """Lay rows on a grid of `rate` ("100 Hz") that begins with the first; ConfigError for what is no rate.

    Each piece is laid with the last row of the one before. What counts as a hole is told by the piece's own
    median spacing.
    """
    grid = Grid(_rate(rate))
    first_ns, number = None, 0
    last: SurfaceTable | None = None
    for piece in pieces:
        rows = piece if last is None else _joined(last, piece)
        first_ns = int(rows.time_ns[0]) if first_ns is None else first_ns
        times = first_ns + grid.until_ns(number, int(rows.time_ns[-1]) - first_ns)
        number += len(times)
        yield _laid(rows, times)
        last = _tail(rows)


def _laid(rows: SurfaceTable, times: np.ndarray) -> SurfaceTable:
    after = np.clip(np.searchsorted(rows.time_ns, times), 0, len(rows) - 1)
    before = np.maximum(after - 1, 0)
    gaps = rows.time_ns[after] - rows.time_ns[before]
    spacing = float(np.median(np.diff(rows.time_ns))) if len(rows) > 1 else 0.0
    told = (gaps <= HOLE * spacing) | (rows.time_ns[after] == times)
    times = times[told]
    # Seconds since the first: as doubles, nanoseconds since 1970 are known to 256.
    at, known = ((each - rows.time_ns[0]) / NS for each in (times, rows.time_ns))
    return SurfaceTable(
        times,
        np.interp(at, known, rows.motor_torque_nm),
        np.interp(at, known, rows.motor_speed_rad_s),
        {topic: _told(depth, rows.time_ns, times) for topic, depth in rows.depths_m.items()},
    )


def _told(depth_m: Floats, at_ns: Times, times: Times) -> Floats:
    """Each depth once, at the next time of the grid: of what comes in steps nothing lies between two."""
    told = np.full(len(times), np.nan)
    known = np.flatnonzero(np.isfinite(depth_m))
    if len(times):
        told[np.minimum(np.searchsorted(times, at_ns[known]), len(times) - 1)] = depth_m[known]
    return told


def _rate(text: str) -> float:
    try:
        rate = to_si(text, "Hz")
    except ValueError as error:
        raise ConfigError(f"--resample: {error}") from error
    if not 0 < rate <= 5000:
        raise ConfigError(f'--resample: {text!r} is no rate up to 5 kHz: write for example "100 Hz"')
    return rate


def _joined(last: SurfaceTable, piece: SurfaceTable) -> SurfaceTable:
    return SurfaceTable(
        np.append(last.time_ns, piece.time_ns),
        np.append(last.motor_torque_nm, piece.motor_torque_nm),
        np.append(last.motor_speed_rad_s, piece.motor_speed_rad_s),
        {topic: np.append(last.depths_m[topic], depth) for topic, depth in piece.depths_m.items()},
    )


def _tail(rows: SurfaceTable) -> SurfaceTable:
    return SurfaceTable(
        rows.time_ns[-1:],
        rows.motor_torque_nm[-1:],
        rows.motor_speed_rad_s[-1:],
        {topic: np.full(1, np.nan) for topic in rows.depths_m},  # it was told
    )
