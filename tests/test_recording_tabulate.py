"""Tables to sessions and back: rows become samples, samples become rows."""

import math
import tempfile
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.recording.reader import Record, Session
from vsensor.recording.tabulate import surface_table
from vsensor.recording.writer import SessionWriter
from vsensor.tables import SurfaceTable, surface_samples

finite = st.floats(allow_nan=False, allow_infinity=False)


def records(*told: tuple[str, int, float]) -> list[Record]:
    return [Record(topic, Sample(time_ns=time_ns, value=value), 0, 0) for topic, time_ns, value in told]


def rows_of(table: SurfaceTable) -> list[tuple[float, ...]]:
    columns = (table.time_s, table.motor_torque_nm, table.motor_speed_rad_s)
    return list(zip(*(column.tolist() for column in columns), strict=True))


def test_a_row_becomes_torque_then_speed_under_one_number() -> None:
    table = SurfaceTable(np.array([0.01, 1.7e9]), np.array([5.0, 6.0]), np.array([7.0, 8.0]))
    assert list(surface_samples(table)) == [
        (SURFACE_TORQUE, Sample(time_ns=10_000_000, value=5.0, sequence=0)),
        (SURFACE_SPEED, Sample(time_ns=10_000_000, value=7.0, sequence=0)),
        (SURFACE_TORQUE, Sample(time_ns=1_700_000_000_000_000_000, value=6.0, sequence=1)),
        (SURFACE_SPEED, Sample(time_ns=1_700_000_000_000_000_000, value=8.0, sequence=1)),
    ]


@given(st.dictionaries(st.integers(0, 10**15), st.tuples(finite, finite), min_size=1, max_size=20))
def test_a_table_through_a_session_comes_back_the_same(rows: dict[int, tuple[float, float]]) -> None:
    times = sorted(rows)
    torque, speed = (np.array([rows[time][n] for time in times]) for n in (0, 1))
    table = SurfaceTable(np.array([time / 1e6 for time in times]), torque, speed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.mcap"
        with SessionWriter(path, configuration="", metadata={"rig": "r"}, compression="none") as writer:
            for topic, sample in surface_samples(table):
                writer.write(topic, sample.SerializeToString(), sample.time_ns, sample.time_ns)
        back = surface_table(Session(path).messages())
    assert back.time_s.tobytes() == table.time_s.tobytes()
    assert back.motor_torque_nm.tobytes() == torque.tobytes()
    assert back.motor_speed_rad_s.tobytes() == speed.tobytes()


def test_channels_sampled_apart_leave_each_other_empty() -> None:
    told = records((SURFACE_SPEED, 2_000_000_000, 4.0), (SURFACE_TORQUE, 1_000_000_000, 3.0))
    (one, torque, no_speed), (two, no_torque, speed) = rows_of(surface_table(told))
    assert (one, torque, two, speed) == (1.0, 3.0, 2.0, 4.0)
    assert math.isnan(no_speed)
    assert math.isnan(no_torque)


def test_of_doubled_samples_the_first_counts() -> None:
    told = records((SURFACE_TORQUE, 0, 3.0), (SURFACE_SPEED, 0, 5.0), (SURFACE_TORQUE, 0, 4.0))
    assert rows_of(surface_table(told)) == [(0.0, 3.0, 5.0)]
