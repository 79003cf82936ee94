"""Tables to sessions and back: rows become samples, samples become rows."""

import math
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.recording import blocks
from vsensor.recording.reader import Session
from vsensor.recording.tabulate import surface_tables
from vsensor.recording.writer import SessionWriter
from vsensor.tables import SurfaceSamples, SurfaceTable

finite = st.floats(allow_nan=False, allow_infinity=False)


def written(path: Path, told: Iterable[tuple[str, Sample]], chunk: int = 10**9) -> Session:
    """A session of these samples, in chunks of so many."""
    with SessionWriter(path, configuration="", metadata={"rig": "r"}, compression="none") as writer:
        for number, (topic, sample) in enumerate(told):
            if number % chunk == 0:
                writer.sync()
            writer.write(topic, sample.SerializeToString(), sample.time_ns, sample.time_ns)
    return Session(path)


def rows_of(session: Session) -> list[tuple[float, ...]]:
    rows: list[tuple[float, ...]] = []
    for table in surface_tables(session):
        columns = (table.time_s, table.motor_torque_nm, table.motor_speed_rad_s)
        rows += zip(*(column.tolist() for column in columns), strict=True)
    return rows


def samples(*told: tuple[str, int, float]) -> list[tuple[str, Sample]]:
    return [(topic, Sample(time_ns=time_ns, value=value)) for topic, time_ns, value in told]


def test_a_row_becomes_torque_then_speed_under_one_number() -> None:
    table = SurfaceTable.at_seconds(np.array([0.01, 1.7e9]), np.array([5.0, 6.0]), np.array([7.0, 8.0]))
    assert list(SurfaceSamples().of(table)) == [
        (SURFACE_TORQUE, Sample(time_ns=10_000_000, value=5.0, sequence=0)),
        (SURFACE_SPEED, Sample(time_ns=10_000_000, value=7.0, sequence=0)),
        (SURFACE_TORQUE, Sample(time_ns=1_700_000_000_000_000_000, value=6.0, sequence=1)),
        (SURFACE_SPEED, Sample(time_ns=1_700_000_000_000_000_000, value=8.0, sequence=1)),
    ]


@given(st.dictionaries(st.integers(0, 10**15), st.tuples(finite, finite), min_size=1, max_size=20))
def test_a_table_through_a_session_comes_back_the_same(rows: dict[int, tuple[float, float]]) -> None:
    times = sorted(rows)
    torque, speed = (np.array([rows[time][n] for time in times]) for n in (0, 1))
    table = SurfaceTable(np.array(times) * 1000, torque, speed)
    with tempfile.TemporaryDirectory() as folder:
        (back,) = surface_tables(written(Path(folder) / "a.mcap", SurfaceSamples().of(table)))
    assert back.time_ns.tobytes() == table.time_ns.tobytes()
    assert back.motor_torque_nm.tobytes() == torque.tobytes()
    assert back.motor_speed_rad_s.tobytes() == speed.tobytes()


def test_channels_sampled_apart_leave_each_other_empty(tmp_path: Path) -> None:
    told = samples((SURFACE_SPEED, 2_000_000_000, 4.0), (SURFACE_TORQUE, 1_000_000_000, 3.0))
    (one, torque, no_speed), (two, no_torque, speed) = rows_of(written(tmp_path / "a.mcap", told))
    assert (one, torque, two, speed) == (1.0, 3.0, 2.0, 4.0)
    assert math.isnan(no_speed)
    assert math.isnan(no_torque)


def test_of_doubled_samples_the_first_counts(tmp_path: Path) -> None:
    told = samples((SURFACE_TORQUE, 0, 3.0), (SURFACE_SPEED, 0, 5.0), (SURFACE_TORQUE, 0, 4.0))
    assert rows_of(written(tmp_path / "a.mcap", told)) == [(0.0, 3.0, 5.0)]


@given(st.lists(st.tuples(st.sampled_from((SURFACE_TORQUE, SURFACE_SPEED)), st.integers(0, 30)), max_size=40))
def test_rows_are_those_of_the_whole_session_however_late_a_sample_comes(
    told: list[tuple[str, int]],
) -> None:
    """Naive twin: all samples in one dictionary, the first of each time and channel, in the order of time."""
    rows: dict[int, dict[str, float]] = {}
    for number, (topic, time_ns) in enumerate(told):
        rows.setdefault(time_ns, {}).setdefault(topic, float(number))
    expected = [
        (time_ns / 1e9, *(rows[time_ns].get(topic) for topic in (SURFACE_TORQUE, SURFACE_SPEED)))
        for time_ns in sorted(rows)
    ]
    sent = samples(*((topic, time_ns, float(number)) for number, (topic, time_ns) in enumerate(told)))
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "BLOCK_BYTES", 1)
        session = written(Path(folder) / "a.mcap", sent, chunk=3)
        found = [tuple(None if math.isnan(value) else value for value in row) for row in rows_of(session)]
    assert found == expected
