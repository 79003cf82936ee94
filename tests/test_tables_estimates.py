"""Estimates tables written: the columns promised, nothing where nothing is known, every bit kept."""

import csv
import math
import struct
import tempfile
from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.errors import ConfigError, InputError
from vsensor.messages import BIT_ESTIMATE, Estimate
from vsensor.recording.reader import Session
from vsensor.recording.tabulate import estimate_tables
from vsensor.recording.writer import SessionWriter
from vsensor.tables import ESTIMATE_FIELDS, TableWriter, write_estimates, writer

PROMISED = (
    "time_s,confirmed_time_s,confirmed_speed_rad_s,confirmed_speed_std_rad_s,confirmed_torque_nm,"
    "confirmed_torque_std_nm,now_speed_rad_s,now_speed_std_rad_s,now_torque_nm,now_torque_std_nm,"
    "forecast_time_s,forecast_speed_rad_s,forecast_speed_std_rad_s,forecast_torque_nm,"
    "forecast_torque_std_nm,quality"
)

any_float = st.floats(allow_nan=False)


def columns_of(values: list[float], quality: str = "good") -> dict[str, np.ndarray]:
    columns = {name: np.array(values) for name in ESTIMATE_FIELDS}
    return columns | {"quality": np.array([quality] * len(values))}


def bits(value: float) -> bytes:
    return struct.pack("<d", value)


def test_the_header_is_as_promised(tmp_path: Path) -> None:
    write_estimates(tmp_path / "a.csv", columns_of([1.0]))
    assert (tmp_path / "a.csv").read_text().splitlines()[0] == PROMISED
    write_estimates(tmp_path / "a.parquet", columns_of([1.0]))
    assert parquet.read_table(tmp_path / "a.parquet").column_names == PROMISED.split(",")


@given(st.lists(any_float, min_size=1, max_size=30))
def test_numbers_read_back_bit_for_bit(values: list[float]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.csv"
        write_estimates(path, columns_of(values))
        with path.open(newline="") as file:
            texts = [row["now_torque_nm"] for row in csv.DictReader(file)]
        write_estimates(path.with_suffix(".parquet"), columns_of(values))
        stored = parquet.read_table(path.with_suffix(".parquet"))["now_torque_nm"].to_pylist()
    assert [bits(float(text)) for text in texts] == list(map(bits, values))
    assert list(map(bits, stored)) == list(map(bits, values))


def test_what_is_not_known_is_empty_or_null(tmp_path: Path) -> None:
    write_estimates(tmp_path / "a.csv", columns_of([math.nan, 2.0], "uncertain"))
    assert (tmp_path / "a.csv").read_text().splitlines()[1:] == [
        "," * 15 + "uncertain",
        "2," * 15 + "uncertain",
    ]
    write_estimates(tmp_path / "a.parquet", columns_of([math.nan, 2.0]))
    assert parquet.read_table(tmp_path / "a.parquet")["now_torque_nm"].to_pylist() == [None, 2.0]


def test_estimates_become_rows(tmp_path: Path) -> None:
    known = Estimate(
        number=0,
        time_ns=1_700_000_000_123_456_789,
        confirmed_time_ns=290_000_000,
        confirmed_bit_speed_rad_s=1.25,
        confirmed_bit_torque_std_nm=7.5,
        forecast_bit_torque_nm=0.0,
        quality=2,  # type: ignore[arg-type]
    )
    session = tmp_path / "a.mcap"
    with SessionWriter(session, configuration="", metadata={"rig": "r"}, compression="none") as writer:
        for told in (known, Estimate(time_ns=10_000_000)):
            writer.write(BIT_ESTIMATE, told.SerializeToString(), 0, 0)
    (columns,) = estimate_tables(Session(session))
    write_estimates(tmp_path / "a.csv", columns)
    with (tmp_path / "a.csv").open(newline="") as file:
        first, second = csv.DictReader(file)
    assert {name: text for name, text in first.items() if text} == {
        "time_s": "1700000000.1234567",
        "confirmed_time_s": "0.29",
        "confirmed_speed_rad_s": "1.25",
        "confirmed_torque_std_nm": "7.5",
        "forecast_torque_nm": "0",
        "quality": "uncertain",
    }
    assert {name: text for name, text in second.items() if text} == {"time_s": "0.01"}


def test_no_field_that_tells_of_the_bit_is_left_out() -> None:
    fields = {field.name for field in Estimate.DESCRIPTOR.fields}
    beside = {field for field in fields if field.startswith("top_")} | {"number", "reasons"}
    beside |= {"stick_in_s", "forecast_shed"}
    assert set(ESTIMATE_FIELDS.values()) == fields - beside


def test_another_kind_of_file_is_wrong_use(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"must end in \.csv or \.parquet"):
        write_estimates(tmp_path / "a.xlsx", columns_of([1.0]))


@pytest.mark.parametrize("suffix", ["csv", "parquet", "npz"])
def test_a_table_that_cannot_be_written_leaves_no_half_of_it(tmp_path: Path, suffix: str) -> None:
    with pytest.raises(InputError, match="cannot be written: No such file or directory"):
        write_estimates(tmp_path / "no" / f"a.{suffix}", columns_of([1.0]))
    (tmp_path / f"a.{suffix}").mkdir()
    with pytest.raises(InputError, match="cannot be written: Is a directory"):
        write_estimates(tmp_path / f"a.{suffix}", columns_of([1.0]))
    assert [path.name for path in tmp_path.iterdir()] == [f"a.{suffix}"]


def test_numpy_has_an_array_a_column(tmp_path: Path) -> None:
    columns = columns_of([math.nan, 2.0, 1 / 3])
    columns["quality"] = np.array(["bad", None, "uncertain"], dtype=object)
    write_estimates(tmp_path / "a.npz", columns)
    with np.load(tmp_path / "a.npz") as found:
        assert found.files == PROMISED.split(",")
        assert found["now_torque_nm"].tobytes() == columns["now_torque_nm"].tobytes()
        assert found["quality"].tolist() == ["bad", "", "uncertain"]


@pytest.mark.parametrize("suffix", ["csv", "parquet", "npz"])
def test_a_table_in_pieces_is_the_table_at_once(
    tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    columns = columns_of([float(k) for k in range(50)])
    write_estimates(tmp_path / f"whole.{suffix}", columns)
    monkeypatch.setattr(writer, "_ROWS", 12)
    with TableWriter(tmp_path / f"pieces.{suffix}", tuple(ESTIMATE_FIELDS)) as pieces:
        for start in range(0, 50, 5):
            pieces.write({name: column[start : start + 5] for name, column in columns.items()})
    assert pieces.rows == 50
    found = [table_of(tmp_path / f"{name}.{suffix}") for name in ("whole", "pieces")]
    assert found[0] == found[1]
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"pieces.{suffix}", f"whole.{suffix}"]


def table_of(path: Path) -> object:
    if path.suffix == ".parquet":
        return parquet.read_table(path).to_pydict()
    if path.suffix == ".npz":
        with np.load(path) as found:
            return {name: found[name].tolist() for name in found.files}
    return path.read_text()


@pytest.mark.parametrize("suffix", ["csv", "parquet", "npz"])
def test_what_fails_on_the_way_leaves_no_half_of_a_table(tmp_path: Path, suffix: str) -> None:
    def fail_on_the_way() -> None:
        with TableWriter(tmp_path / f"a.{suffix}", ("time_s",)) as half:
            half.write({"time_s": np.zeros(200_000)})
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_on_the_way()
    assert list(tmp_path.iterdir()) == []
