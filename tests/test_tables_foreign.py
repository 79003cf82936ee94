"""Tables as other countries and loggers write them: decimal commas, no-value numbers, more lines."""

import math
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest

from vsensor.errors import ConfigError, InputError
from vsensor.tables import Findings, Head, Layout, TimeForm, read_surface, surface_pieces

HEADER = "time_s;motor_torque_nm;motor_speed_rad_s\n"
UNITS = "Time,STOR,RPM\n"
NAMED = Layout(time="Time", torque="STOR", speed="RPM")


def csv_file(folder: Path, text: str) -> Path:
    path = folder / "surface.csv"
    path.write_text(text)
    return path


@pytest.mark.parametrize("mark", [";", "\t"])
def test_where_columns_are_not_parted_by_commas_decimals_may_be(tmp_path: Path, mark: str) -> None:
    text = HEADER + "0,0;8000,25;-6,5e-1\n0,01; 8001 ;\n1,5;,5;+7\n"
    table = read_surface(csv_file(tmp_path, text.replace(";", mark)))
    assert table.time_ns.tolist() == [0, 10_000_000, 1_500_000_000]
    assert table.motor_torque_nm.tolist() == [8000.25, 8001.0, 0.5]
    np.testing.assert_array_equal(table.motor_speed_rad_s, [-0.65, math.nan, 7.0])


def test_one_column_may_have_commas_and_another_points(tmp_path: Path) -> None:
    table = read_surface(csv_file(tmp_path, HEADER + "0.5;1,5;2\n"))
    assert (table.time_s.tolist(), table.motor_torque_nm.tolist()) == ([0.5], [1.5])


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (
            "0;999.5;1\n1;1,001;1\n",
            "line 3: motor_torque_nm is '1,001', where others of the column have a point",
        ),
        (
            "0;1,001;1\n1;999.5;1\n",
            "line 2: motor_torque_nm is '1,001', where others of the column have a point",
        ),
        ("0;1,234.5;1\n", "line 2: motor_torque_nm is '1,234.5': .* without marks between thousands"),
        ("0;1.234,5;1\n", "line 2: motor_torque_nm is '1.234,5': .* without marks between thousands"),
    ],
)
def test_marks_between_thousands_are_refused(tmp_path: Path, rows: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_surface(csv_file(tmp_path, HEADER + rows))


def test_so_they_are_far_from_the_first_decimal(tmp_path: Path) -> None:
    rows = [f"{n};999.5;1\n" for n in range(150_000)]
    rows[140_000] = "140000;1,000;1\n"
    with pytest.raises(InputError, match="line 140002: motor_torque_nm is '1,000'"):
        read_surface(csv_file(tmp_path, HEADER + "".join(rows)))


@pytest.mark.parametrize("told", ["-999.25", "-999.2500", "-9.9925e2"])
def test_a_number_that_stands_for_no_value_is_none(tmp_path: Path, told: str) -> None:
    text = f"time_s,motor_torque_nm,motor_speed_rad_s,DBTM\n0,{told},1,{told}\n1,-999,{told},5\n"
    path = csv_file(tmp_path, text)
    (table,) = surface_pieces(path, Layout(bit_depth="DBTM", nulls=(-999.25,)))
    np.testing.assert_array_equal(table.motor_torque_nm, [math.nan, -999])
    np.testing.assert_array_equal(table.motor_speed_rad_s, [1, math.nan])
    (depth,) = table.depths_m.values()
    np.testing.assert_array_equal(depth, [math.nan, 5])
    with pytest.raises(InputError, match="line 2: motor_torque_nm is empty"):
        list(surface_pieces(path, Layout(nulls=(-999.25,)), whole=True))


@pytest.mark.parametrize("kind", [pa.float32(), pa.float64(), pa.string(), pa.int16()])
def test_so_it_is_in_columns_of_every_type(tmp_path: Path, kind: pa.DataType) -> None:
    told = -999 if pa.types.is_integer(kind) else -999.1
    column = pa.array([str(told), "2"]).cast(kind)
    columns = {"time_s": [0, 1], "motor_torque_nm": column, "motor_speed_rad_s": [1.0, 2.0]}
    parquet.write_table(pa.table(columns), tmp_path / "a.parquet")
    table = read_surface(tmp_path / "a.parquet", Layout(nulls=(told, 7.0)))
    np.testing.assert_array_equal(table.motor_torque_nm, [math.nan, 2])


def test_what_looks_like_no_value_is_said_and_read_all_the_same(tmp_path: Path) -> None:
    rows = "0,-999.25,-9999\n1,-999.25,1\n2,5,\n"
    path, findings = csv_file(tmp_path, HEADER.replace(";", ",") + rows), Findings()
    (table,) = surface_pieces(path, Layout(torque_unit="kN*m"), findings=findings)
    assert table.motor_torque_nm.tolist() == [-999_250, -999_250, 5000]
    assert list(findings.words()) == [
        "2 cells of motor_torque_nm are -999.25: if that stands for no value, --null -999.25",
        "1 cell of motor_speed_rad_s is -9999: if that stands for no value, --null -9999",
    ]


def test_a_channel_without_any_value_is_said_and_both_are_refused(tmp_path: Path) -> None:
    path, findings = csv_file(tmp_path, HEADER.replace(";", ",") + "0,1,\n1,1,\n"), Findings()
    list(surface_pieces(path, findings=findings))
    assert list(findings.words()) == ["motor_speed_rad_s has no value at all"]
    with pytest.raises(InputError, match="neither motor_torque_nm nor motor_speed_rad_s has any value"):
        list(surface_pieces(path, Layout(nulls=(1.0,))))


ABOUT = 'Well: 15/9-F-1, "B"\n\nrun;7\n'


@pytest.mark.parametrize("blank", ["", "\n"])
def test_lines_before_the_header_are_left_out(tmp_path: Path, blank: str) -> None:
    path = csv_file(tmp_path, ABOUT + HEADER + blank + "0;1,5;2\n1;x;2\n")
    line = 6 + len(blank)
    with pytest.raises(InputError, match=f"line {line}: motor_torque_nm is 'x'"):
        read_surface(path, Layout(head=Head(skipped=3)))
    path.write_text(path.read_text().replace("x;2", "3"))
    with pytest.raises(InputError, match=f"line {line}: has 2 values"):
        read_surface(path, Layout(head=Head(skipped=3)))
    path.write_text(path.read_text().replace("1;3", "1;3;4"))
    assert read_surface(path, Layout(head=Head(skipped=3))).motor_torque_nm.tolist() == [1.5, 3.0]


def test_a_header_further_down_is_found_and_said(tmp_path: Path) -> None:
    path = csv_file(tmp_path, ABOUT + HEADER + "0;1;2\n")
    with pytest.raises(InputError, match="line 4 has all of them: vsensor import --skip-lines 3"):
        read_surface(path)


@pytest.mark.parametrize("line", ["s,kN.m,rpm", ",[kN·m],(rpm)", '"","kN*m","rpm"'])
def test_a_line_of_units_is_named_and_read_where_asked(tmp_path: Path, line: str) -> None:
    path = csv_file(tmp_path, UNITS + line + "\n0,2,60\n1,3,120\n2,x,0\n")
    with pytest.raises(InputError, match=r"line 2: .* a line of units. vsensor import --units-line"):
        read_surface(path, NAMED)
    told = Layout(time="Time", torque="STOR", speed="RPM", head=Head(units=True))
    with pytest.raises(InputError, match="line 5: STOR is 'x'"):
        read_surface(path, told)
    path.write_text(path.read_text().replace("2,x,0\n", ""))
    table = read_surface(path, told)
    assert table.motor_torque_nm.tolist() == [2000.0, 3000.0]
    assert table.motor_speed_rad_s == pytest.approx([2 * math.pi, 4 * math.pi])


def test_a_unit_that_an_option_tells_goes_before_that_of_the_line(tmp_path: Path) -> None:
    path = csv_file(tmp_path, "Well: A\nTime,STOR,RPM,DBTM\nms,klbf.ft,rpm,ft\n1500,2,60,1000\n")
    told = Layout("Time", "STOR", "RPM", torque_unit="N*m", bit_depth="DBTM", head=Head(1, units=True))
    (table,) = surface_pieces(path, told)
    assert (table.time_s.tolist(), table.motor_torque_nm.tolist()) == ([1.5], [2.0])
    (depth,) = table.depths_m.values()
    assert depth == pytest.approx([304.8])
    path.write_text(path.read_text().replace("klbf.ft", "klbf.ft x"))
    with pytest.raises(ConfigError, match=r"surface\.csv: 'klbf\.ft x' is no unit for motor_torque_nm"):
        list(surface_pieces(path, Layout("Time", "STOR", "RPM", head=Head(1, units=True))))


def test_a_line_of_units_may_describe_what_is_no_number(tmp_path: Path) -> None:
    path = csv_file(tmp_path, UNITS + "yyyy-mm-dd hh:mm:ss,kN.m,rpm\n2026-11-24 08:15:30,2,60\n")
    table = read_surface(path, Layout("Time", "STOR", "RPM", head=Head(units=True)))
    assert table.time_ns.tolist() == [1_795_508_130 * 10**9]


def test_only_csv_has_lines_about_its_header(tmp_path: Path) -> None:
    parquet.write_table(pa.table({"a": [1]}), tmp_path / "a.parquet")
    with pytest.raises(ConfigError, match=r"a\.parquet: only a \.csv has lines before its header"):
        read_surface(tmp_path / "a.parquet", Layout(head=Head(2)))


@pytest.mark.parametrize(
    ("rows", "form", "said"),
    [
        (
            "1774749590.004,1,1\n1774749590.003,1,1\n",
            TimeForm(),
            "is 1774749590.003 s after 1774749590.004 s",
        ),
        (
            "2026-03-29 02:00,1,1\n2026-03-29 01:59,1,1\n",
            TimeForm(),
            "is 2026-03-29 01:59 after 2026-03-29 02:00",
        ),
        ("2:00,1,1\n1:59,1,1\n", TimeForm(pattern="%H:%M"), "is 1:59 after 2:00"),
        ("5,1,1\n-0.5,1,1\n", TimeForm(), "is -0.5 s: a session's times begin with 0"),
        ("-0.5,1,1\n5,1,1\n", TimeForm(), "is -0.5 s: a session's times begin with 0"),
        ("1969-12-31T23:59:59,1,1\n", TimeForm(), "is 1969-12-31T23:59:59: a session's times begin with 0"),
        (
            "29.03.2026 01:59:50,1,1\n",
            TimeForm(),
            "is '29.03.2026 01:59:50': .* --time-format .* --date-column",
        ),
        ("1774749590000,1,1\n", TimeForm(), "is .* which no clock shows: .* --time-unit"),
    ],
)
def test_a_wrong_time_is_told_as_it_stands_there(
    tmp_path: Path, rows: str, form: TimeForm, said: str
) -> None:
    path = csv_file(tmp_path, HEADER.replace(";", ",") + rows)
    with pytest.raises(InputError, match=f"line [23]: time_s {said}"):
        read_surface(path, Layout(form=form))


def test_so_it_is_from_one_batch_of_rows_to_the_next_and_in_times_of_their_own_type(tmp_path: Path) -> None:
    times = [*(n * 1000 for n in range(70_000)), 69_998_001]
    ones = pa.array(np.ones(len(times)))
    columns = {"motor_torque_nm": ones, "motor_speed_rad_s": ones}
    for column, said in (
        (pa.array(times, pa.timestamp("ms")), "is 1970-01-01T19:26:38.001.* after 1970-01-01T19:26:39"),
        (pa.array(times, pa.duration("ms")), "is 69998.001 s after 69999 s"),
    ):
        table = pa.table({"time_s": column} | columns)
        parquet.write_table(table, tmp_path / "a.parquet", row_group_size=70_000)
        with pytest.raises(InputError, match=f"row 70001: time_s {said}"):
            read_surface(tmp_path / "a.parquet")


def test_a_column_that_is_missing_names_its_option(tmp_path: Path) -> None:
    path = csv_file(tmp_path, "time_s,motor_torque_nm,RPM\n0,1,2\n")
    with pytest.raises(InputError, match="'RPM': vsensor import --speed-column names another"):
        read_surface(path)
