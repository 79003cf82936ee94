"""Surface tables read: what comes in, and where exactly a bad one is bad."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.errors import ConfigError, InputError
from vsensor.tables import Layout, SurfaceTable, TimeForm, read_surface, surface_pieces, write_surface

HEADER = "time_s,motor_torque_nm,motor_speed_rad_s\n"


def csv_file(folder: Path, text: str | bytes) -> Path:
    path = folder / "surface.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def parquet_file(folder: Path, **columns: Any) -> Path:
    path = folder / "surface.parquet"
    given_columns = {"time_s": [0.0, 0.1], "motor_torque_nm": [1.0, 2.0], "motor_speed_rad_s": [3.0, 4.0]}
    parquet.write_table(pa.table(given_columns | columns), path)
    return path


def columns_of(table: SurfaceTable) -> list[list[float]]:
    return [table.time_s.tolist(), table.motor_torque_nm.tolist(), table.motor_speed_rad_s.tolist()]


@pytest.mark.parametrize(
    "text",
    [
        HEADER + "0.5,10,-1.5e-1\n0.75,11.5,2\n",
        "\ufeff" + HEADER.replace("\n", "\r\n") + "0.5,10,-0.15\r\n0.75,11.5,2\r\n",
        '"motor_speed_rad_s","remark","time_s","motor_torque_nm"\n-.15,"a ""b""",0.5,10\n2,,.75,11.5',
        "\n" + HEADER + "\n 0.5 , 10,-0.15\n\n+0.75,11.5,2.0\n\n",
        HEADER.replace(",", ", ") + "0.5, 10, -0.15\n0.75, 11.5, 2.0\n",
        "\ufeffsep=;\r\n" + HEADER.replace(",", ";") + "0.5;10;-0.15\n0.75;11.5;2\n",
        'SEP=|\n\n"a;b;c;d"|' + HEADER.replace(",", "|") + "1|0.5|10|-0.15\n2|0.75|11.5|2\n",
    ],
    ids=[
        "plain",
        "windows",
        "other order and columns",
        "blank lines and spaces",
        "spaces after commas",
        "excel",
        "excel, parted by bars",
    ],
)
def test_csv_is_read_as_rigs_write_it(tmp_path: Path, text: str) -> None:
    assert columns_of(read_surface(csv_file(tmp_path, text))) == [[0.5, 0.75], [10.0, 11.5], [-0.15, 2.0]]


def test_the_ending_of_a_name_may_be_written_large(tmp_path: Path) -> None:
    path = csv_file(tmp_path, HEADER + "0.5,10,-0.15\n").rename(tmp_path / "SURFACE.CSV")
    assert columns_of(read_surface(path)) == [[0.5], [10.0], [-0.15]]


def test_parquet_is_read_whatever_its_number_types(tmp_path: Path) -> None:
    path = parquet_file(
        tmp_path,
        time_s=pa.array([1, 2], pa.int64()),
        motor_torque_nm=pa.array([1.5, 2.5], pa.float32()),
        motor_speed_rad_s=pa.array(["3", "4.25"]),
        remark=["a", "b"],
    )
    assert columns_of(read_surface(path)) == [[1.0, 2.0], [1.5, 2.5], [3.0, 4.25]]


@pytest.mark.parametrize("empty", ["", " ", '""', "nan", "NaN"])
def test_a_cell_without_a_number_is_a_channel_without_a_sample(tmp_path: Path, empty: str) -> None:
    table = read_surface(csv_file(tmp_path, HEADER + f"0,1,{empty}\n1,{empty},2\n2,{empty},{empty}\n3,4,5\n"))
    assert table.time_s.tolist() == [0.0, 1.0, 2.0, 3.0]
    np.testing.assert_array_equal(table.motor_torque_nm, [1, math.nan, math.nan, 4])
    np.testing.assert_array_equal(table.motor_speed_rad_s, [math.nan, 2, math.nan, 5])
    with pytest.raises(InputError, match=r"surface\.csv, line 3: motor_torque_nm is (empty|nan)"):
        list(surface_pieces(tmp_path / "surface.csv", whole=True))


@pytest.mark.parametrize("torque", [[None, 2.0], [math.nan, 2.0], [None, "2"]])
def test_so_it_is_in_a_parquet_table(tmp_path: Path, torque: list[Any]) -> None:
    path = parquet_file(tmp_path, motor_torque_nm=torque, motor_speed_rad_s=[None, None])
    table = read_surface(path)
    np.testing.assert_array_equal(table.motor_torque_nm, [math.nan, 2])
    np.testing.assert_array_equal(table.motor_speed_rad_s, [math.nan, math.nan])


def test_other_names_and_units(tmp_path: Path) -> None:
    path = csv_file(tmp_path, "t,TQ,RPM\n1500,2,60\n1600,4,120\n")
    table = read_surface(
        path,
        Layout("t", "TQ", "RPM", form=TimeForm("ms"), torque_unit="kft*lbf", speed_unit="rpm"),
    )
    assert table.time_s == pytest.approx([1.5, 1.6])
    assert table.motor_torque_nm == pytest.approx([2711.6359, 5423.2718])
    assert table.motor_speed_rad_s == pytest.approx([2 * math.pi, 4 * math.pi])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        (HEADER, "has a header but no rows"),
        ("time_s,torque\n0,1\n", "has no column 'motor_torque_nm'; its columns are: 'time_s', 'torque'"),
        ("time_s," + HEADER + "0,0,1,2\n", "has more than one column 'time_s'"),
        (HEADER + "0,1,2\n1,1\n", "line 3: has 2 values, where the header names 3"),
        (HEADER + "0,1,2\n\n\n1,1,2,3\n", "line 5: has 4 values, where the header names 3"),
        ("sep=,\n" + HEADER + "0,1,2\n\n1,1\n", "line 5: has 2 values, where the header names 3"),
        ("sep=,\n" + HEADER + "0,1,2\n1,high,2\n", "line 4: motor_torque_nm is 'high'"),
        ("sep=;\n", "is empty: a header and rows were expected"),
        ("sep=;\n" + HEADER + "0,1,2\n", "has no column 'time_s'; its columns are: 'time_s,motor_torque_nm"),
        (HEADER + "0,1,2\n1,high,2\n", "line 3: motor_torque_nm is 'high': a finite number was expected"),
        (HEADER + "0,1,2\n\n1,2,1_0\n", "line 4: motor_speed_rad_s is '1_0'"),
        (HEADER + "0,1,2\n,1,2\n", "line 3: time_s is empty"),
        (HEADER + "0,1,2\nnan,1,2\n", "line 3: time_s is nan"),
        (HEADER + "0,-inf,2\n", "line 2: motor_torque_nm is -inf"),
        (HEADER + "0,1e999,2\n", "line 2: motor_torque_nm is inf"),
        (HEADER + "0,1,2\n1,1,2\n1,1,2\n", "line 4: time_s is 1 s after 1 s: time must increase"),
        (HEADER + "0,1,2\n5,1,2\n\n4.5,1,2\n", "line 5: time_s is 4.5 s after 5 s"),
        (HEADER + "1700000000000,1,2\n", "line 2: time_s is 1.7e\\+12 s, .* another unit"),
        (b"\x00\x01\x02\x03" * 10, "has no column 'time_s'"),
        (HEADER.encode() + b"0,1\xff,2\n", "is not UTF-8: save it as UTF-8"),
        ((HEADER + "0,1,2\n").encode("utf-16"), "is not UTF-8: save it as UTF-8"),
        ("Zéit,M,n\n0,1,2\n".encode("latin-1"), "is not UTF-8: save it as UTF-8"),
        (HEADER + '0,"1,5",2\n', "line 2: motor_torque_nm is '1,5': .* a point, such as 1.5"),
        ("x" * 200_000, "is no CSV table: field larger"),
    ],
)
def test_a_bad_csv_table_is_refused_with_its_place(tmp_path: Path, text: str | bytes, said: str) -> None:
    with pytest.raises(InputError, match=rf"surface\.csv(:|,) {said}"):
        read_surface(csv_file(tmp_path, text))


def test_the_line_is_right_far_down_a_long_table(tmp_path: Path) -> None:
    rows = [f"{n},1,2\n" for n in range(200_000)]
    rows[150_000] = "150000,x,2\n"
    with pytest.raises(InputError, match="line 150002: motor_torque_nm is 'x'"):
        read_surface(csv_file(tmp_path, HEADER + "".join(rows)))
    rows[150_000] = "150000,1\n"
    with pytest.raises(InputError, match="line 150002: has 2 values"):
        read_surface(csv_file(tmp_path, HEADER + "".join(rows)))


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"time_s": [1.0, None]}, "row 2: time_s is empty"),
        ({"time_s": [math.nan, 1.0]}, "row 1: time_s is nan"),
        ({"motor_torque_nm": ["1", "x"]}, "row 2: motor_torque_nm is 'x'"),
        ({"motor_torque_nm": [True, False]}, "row 1: motor_torque_nm is of type bool"),
        ({"time_s": [1.0, 1.0]}, "row 2: time_s is 1 s after 1 s"),
    ],
)
def test_a_bad_parquet_table_is_refused_with_its_row(
    tmp_path: Path, columns: dict[str, Any], said: str
) -> None:
    with pytest.raises(InputError, match=rf"surface\.parquet, {said}"):
        read_surface(parquet_file(tmp_path, **columns))


def test_a_parquet_table_without_a_column_is_refused(tmp_path: Path) -> None:
    parquet.write_table(pa.table({"a": [1]}), tmp_path / "a.parquet")
    with pytest.raises(InputError, match="has no column 'time_s'; its columns are: 'a'"):
        read_surface(tmp_path / "a.parquet")


@pytest.mark.parametrize("content", [b"", b"hello", b"PAR1" * 30])
def test_what_is_no_parquet_is_said_to_be_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.parquet").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.parquet: is no Parquet table"):
        read_surface(tmp_path / "a.parquet")


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_a_missing_file_and_a_folder_are_named(tmp_path: Path, suffix: str) -> None:
    with pytest.raises(InputError, match=rf"no\.{suffix}: cannot be read: No such file"):
        read_surface(tmp_path / f"no.{suffix}")
    (tmp_path / f"folder.{suffix}").mkdir()
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        read_surface(tmp_path / f"folder.{suffix}")


def test_another_kind_of_file_is_wrong_use(tmp_path: Path) -> None:
    with pytest.raises(
        ConfigError, match=r"a\.xlsx: a table's name must end in \.csv or \.parquet or \.feather"
    ):
        read_surface(tmp_path / "a.xlsx")


@pytest.mark.parametrize("unit", ["rpm", "N*m*s", "furlong per", "Hz"])
def test_a_unit_that_does_not_fit_is_wrong_use(tmp_path: Path, unit: str) -> None:
    path = csv_file(tmp_path, HEADER + "0,1,2\n")
    with pytest.raises(ConfigError, match="is no unit for motor_torque_nm: write for example 'N\\*m'"):
        read_surface(path, Layout(torque_unit=unit))


@given(st.lists(st.integers(0, 1 << 61), min_size=1, max_size=20))
def test_times_become_the_nearest_nanosecond(times_ns: list[int]) -> None:
    times_s = np.array([time_ns / 10**9 for time_ns in times_ns])
    found = SurfaceTable.at_seconds(times_s, times_s, times_s).time_ns
    for time_s, time_ns in zip(times_s.tolist(), found.tolist(), strict=True):
        exact = time_s.as_integer_ratio()
        assert abs(time_ns * exact[1] - exact[0] * 10**9) * 2 <= exact[1] * (1 + 1e-6)
        assert time_ns / 10**9 == time_s


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_what_is_written_reads_back_bit_for_bit(tmp_path: Path, suffix: str) -> None:
    table = SurfaceTable.at_seconds(
        np.array([0.1, 0.2, 0.333_333_333]), np.array([-0.0, 5e-324, 1e22]), np.array([1.0, 2.0, 3.0])
    )
    path = tmp_path / f"a.{suffix}"
    write_surface(path, table)
    read = read_surface(path)
    assert [column.tobytes() for column in (read.time_s, read.motor_torque_nm, read.motor_speed_rad_s)] == [
        column.tobytes() for column in (table.time_s, table.motor_torque_nm, table.motor_speed_rad_s)
    ]
