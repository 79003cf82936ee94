"""Times in the forms that loggers write: the same nanoseconds come of all, or a row is refused."""

import datetime as dt
from pathlib import Path
from typing import Any
from zoneinfo import ZoneInfo

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.errors import ConfigError, InputError
from vsensor.tables import Layout, TimeForm, read_surface
from vsensor.tables.cells import BadCellError
from vsensor.tables.course import Course

UTC = dt.UTC
MOMENT = dt.datetime(2026, 11, 24, 8, 15, 30, 250_000, UTC)
MOMENT_NS = round(MOMENT.timestamp()) * 10**9 + 250_000_000


def read(value: Any, form: TimeForm = TimeForm(), kind: Any = None) -> int:  # noqa: B008
    (time_ns,) = form.read(pa.array([value], kind)).tolist()
    return int(time_ns)


def test_a_time_of_day_alone_counts_from_midnight() -> None:
    """Of no year strptime makes 1900, before which a session's clock cannot be."""
    assert read("00:00:30.25", TimeForm(pattern="%H:%M:%S.%f")) == 30_250_000_000
    assert read("2 00:00:01", TimeForm(pattern="%d %H:%M:%S")) == 86_401_000_000_000


@pytest.mark.parametrize(
    ("told", "form"),
    [
        ("2026-11-24T08:15:30.25", TimeForm()),
        ("2026-11-24 08:15:30.250", TimeForm()),
        (" 2026-11-24T08:15:30.250000000Z ", TimeForm()),
        ("2026-11-24T09:15:30.25+01:00", TimeForm()),
        ("2026/11/24 08:15:30.25", TimeForm()),
        ("2026.11.24 08:15:30.25", TimeForm()),
        ("20261124 08:15:30.25", TimeForm()),
        ("2026-11-24T09:15:30.25", TimeForm(zone="Europe/Oslo")),
        ("2026-11-24T08:15:30,25", TimeForm()),
        ("20261124T081530.25Z", TimeForm()),
        ("20261124T081530,25", TimeForm()),
        ("20261124T101530.25+0200", TimeForm()),
        ("2026-11-24 08:15:30.25 UTC", TimeForm()),
        ("2026-11-24 08:15:30.25UTC", TimeForm(zone="Europe/Oslo")),
        ("2026-11-24 10:15:30.25 +02:00", TimeForm()),
        ("2026-11-24 04:15:30.25 -04:00", TimeForm()),
        ("24.11.2026 08:15:30.250", TimeForm(pattern="%d.%m.%Y %H:%M:%S.%f")),
        ("11/24/26 03:15:30.25 AM", TimeForm(pattern="%m/%d/%y %I:%M:%S.%f %p", zone="America/New_York")),
        (f"{MOMENT_NS}", TimeForm("ns")),
        (f"{MOMENT_NS // 10**6}", TimeForm("ms")),
        (f"{MOMENT_NS // 10**3}", TimeForm("us")),
        (f"{MOMENT_NS // 10**9}.25", TimeForm()),
        (f"{MOMENT_NS / 60e9!r}", TimeForm("min")),
    ],
)
def test_text_of_every_usual_form_is_read(told: str, form: TimeForm) -> None:
    assert abs(read(told, form) - MOMENT_NS) <= (0 if form.unit != "min" else 1000)


@pytest.mark.parametrize(
    "column",
    [
        pa.array([MOMENT], pa.timestamp("us", "UTC")),
        pa.array([MOMENT.replace(tzinfo=None)], pa.timestamp("ms")),
        pa.array([MOMENT.astimezone(dt.timezone(dt.timedelta(hours=3)))], pa.timestamp("ns", "+03:00")),
        pa.array([MOMENT.isoformat()]).dictionary_encode(),
        pa.array([MOMENT.isoformat()], pa.large_string()),
    ],
)
def test_typed_columns_are_read(column: pa.Array) -> None:
    assert TimeForm().read(column).tolist() == [MOMENT_NS]


HOURS = [0, 23 * 3600 + 3599.5, 0.5, 7, 23 * 3600, 1]
ON_DAYS = [0, 86_399.5, 86_400.5, 86_407, 86_400 + 23 * 3600, 172_801]


@pytest.mark.parametrize(
    "column",
    [
        pa.array([round(s * 1000) for s in HOURS], pa.int32()).cast(pa.time32("ms")),
        pa.array([round(s * 1e9) for s in HOURS], pa.time64("ns")),
        pa.array([str(np.datetime64(round(s * 1000), "ms"))[11:] for s in HOURS]),
        pa.array([str(np.datetime64(round(s * 1000), "ms"))[11:].replace(".", ",") for s in HOURS]),
    ],
    ids=["time32", "time64", "text", "text with commas"],
)
@pytest.mark.parametrize("cut", [1, 2, 3, 6])
def test_a_time_of_day_goes_on_over_midnight(column: pa.Array, cut: int) -> None:
    """Also where midnight falls between two pieces of a table, and whatever the zone."""
    course, form = Course(), TimeForm(zone="Europe/Oslo")
    pieces = [column[start : start + cut] for start in range(0, len(column), cut)]
    found = np.concatenate([form.read(piece, course=course) for piece in pieces])
    assert found.tolist() == [s * 10**9 for s in ON_DAYS]


def test_so_does_one_in_a_form_of_its_own_but_not_one_with_a_day() -> None:
    form = TimeForm(pattern="%I:%M %p", zone="Europe/Oslo")
    assert (form.read(pa.array(["11:59 PM", "12:01 AM"])) // 60_000_000_000).tolist() == [1439, 1441]
    form = TimeForm(pattern="%d %H:%M")
    assert (form.read(pa.array(["02 23:59", "01 00:01"])) // 60_000_000_000).tolist() == [2879, 1]


def test_a_time_of_day_that_comes_a_little_late_is_of_the_same_day() -> None:
    found = TimeForm().read(pa.array(["08:00:02", "08:00:01", "20:00:00", "08:00:01"]))
    assert (found // 10**9).tolist() == [28_802, 28_801, 72_000, 28_801]


def test_a_span_of_time_is_read() -> None:
    for unit, times in (("s", 10**9), ("ms", 10**6), ("ns", 1)):
        assert TimeForm().read(pa.array([0, 5], pa.duration(unit))).tolist() == [0, 5 * times]


AUTUMN_NS = 1_793_490_600 * 10**9
"""2026-10-31T23:50:00Z. In New York the hour from 06:00Z on shows what that before it showed."""


@pytest.mark.parametrize("form", ["iso", "pattern", "stamps"])
@pytest.mark.parametrize("cut", [1, 7, 100, 1000])
def test_an_hour_that_comes_twice_is_told_by_the_order(form: str, cut: int) -> None:
    """Every 5 min over two autumns and a spring between, in pieces."""
    zone = ZoneInfo("America/New_York")
    days = [AUTUMN_NS, AUTUMN_NS + 133 * 86_400 * 10**9, AUTUMN_NS + 371 * 86_400 * 10**9]
    expected = [day + k * 300 * 10**9 for day in days for k in range(144)]
    walls = [dt.datetime.fromtimestamp(time_ns // 10**9, zone).replace(tzinfo=None) for time_ns in expected]
    assert len(set(walls)) == len(walls) - 24
    if form == "stamps":
        column, read = pa.array(walls, pa.timestamp("us")), TimeForm(zone=zone.key)
    elif form == "iso":
        column, read = pa.array([wall.isoformat(" ") for wall in walls]), TimeForm(zone=zone.key)
    else:
        pattern = "%d.%m.%Y %H:%M:%S"
        column = pa.array([wall.strftime(pattern) for wall in walls])
        read = TimeForm(pattern=pattern, zone=zone.key)
    course = Course()
    pieces = [column[start : start + cut] for start in range(0, len(column), cut)]
    assert np.concatenate([read.read(piece, course=course) for piece in pieces]).tolist() == expected


@pytest.mark.parametrize(
    ("dates", "times"),
    [
        (pa.array(["2026-11-24"]), pa.array(["08:15:30.25"])),
        (pa.array(["2026/11/24"]), pa.array(["08:15:30.25"])),
        (pa.array([20261124]), pa.array(["08:15:30.250"])),
        (pa.array([MOMENT.date()]), pa.array([MOMENT.time()])),
    ],
)
def test_date_and_time_of_day_may_stand_apart(dates: pa.Array, times: pa.Array) -> None:
    assert TimeForm().read(times, dates).tolist() == [MOMENT_NS]


def test_date_and_time_of_day_in_a_form_of_their_own() -> None:
    form = TimeForm(pattern="%d.%m.%Y %H:%M:%S")
    assert form.read(pa.array(["08:15:30"]), pa.array(["24.11.2026"])).tolist() == [MOMENT_NS - 250_000_000]


@given(st.lists(st.integers(-(8 * 10**18), 8 * 10**18), min_size=1), st.sampled_from(["text", "number"]))
def test_nanoseconds_are_read_exactly(times_ns: list[int], told: str) -> None:
    column = pa.array(list(map(str, times_ns)) if told == "text" else times_ns)
    assert TimeForm("ns").read(column).tolist() == times_ns


@given(st.lists(st.integers(0, 1 << 61), min_size=1))
def test_iso_times_are_read_exactly(times_ns: list[int]) -> None:
    told = [str(np.datetime64(time_ns, "ns")) for time_ns in times_ns]
    assert TimeForm().read(pa.array(told)).tolist() == times_ns
    assert TimeForm().read(pa.array([f"{text}Z" for text in told])).tolist() == times_ns


@pytest.mark.parametrize(
    ("values", "form", "row", "said"),
    [
        (["2026-11-24T08:00", "2026-13-24T08:00"], TimeForm(), 1, "a time such as 2026-11-24T08:15:30.25"),
        (["2026-11-24T08:00Z", "2026-11-24T08:00"], TimeForm(), 1, "a time such as"),
        (["2026-11-24T08:00", "noon"], TimeForm(), 1, "is 'noon'"),
        (["noon"], TimeForm(), 0, "is 'noon'"),
        (["24.11.2026", "24/11/2026"], TimeForm(pattern="%d.%m.%Y"), 1, "of the form '%d.%m.%Y'"),
        (["0", "later"], TimeForm(), 1, "is 'later': a finite number"),
        ([0.0, 1.8e12], TimeForm(), 1, "which no clock shows"),
        ([0, 1_800_000_000_000], TimeForm(), 1, "which no clock shows"),
        ([0.0, None], TimeForm(), 1, "is empty"),
        ([True], TimeForm(), 0, "is of type bool"),
        (["08:00:00", "later"], TimeForm(), 1, "is 'later'"),
        (pa.array([0, 1 << 40], pa.timestamp("s")), TimeForm(), 1, "further from 1970"),
    ],
)
def test_what_is_no_time_is_refused_by_its_row(
    values: list[Any], form: TimeForm, row: int, said: str
) -> None:
    with pytest.raises(BadCellError, match=said) as caught:
        form.read(pa.array(values))
    assert caught.value.row == row


def test_an_unknown_unit_or_zone_is_wrong_use(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"'rpm' is no unit of time: write for example 'ms'"):
        read(1.5, TimeForm("rpm"))
    path = tmp_path / "a.csv"
    path.write_text("t,motor_torque_nm,motor_speed_rad_s\n2026-11-24T08:00,1,2\n")
    with pytest.raises(
        ConfigError, match=r"a\.csv: t: 'Oslo' is no time zone: write for example 'Europe/Oslo'"
    ):
        read_surface(path, Layout(time="t", form=TimeForm(zone="Oslo")))
    with pytest.raises(ConfigError, match=r"'Europe' is no time zone"):  # but a folder of them
        read_surface(path, Layout(time="t", form=TimeForm(zone="Europe")))


def test_columns_may_be_parted_by_semicolons_or_tabs(tmp_path: Path) -> None:
    for mark in ";\t":
        path = tmp_path / "a.csv"
        rows = [
            "Date,Time,motor_torque_nm,motor_speed_rad_s",
            "2026-11-24,08:15:30.25,1.5,2",
            "2026-11-24,08:15:31,1,2",
        ]
        path.write_text("\n".join(rows).replace(",", mark))
        table = read_surface(path, Layout(time="Time", date="Date"))
        assert table.time_ns.tolist() == [MOMENT_NS, MOMENT_NS + 750_000_000]
        assert table.motor_torque_nm.tolist() == [1.5, 1.0]


def test_arrow_files_are_read(tmp_path: Path) -> None:
    from pyarrow import feather

    columns = {"time_s": [0.0, 0.1], "motor_torque_nm": [1.0, 2.0], "motor_speed_rad_s": [3.0, 4.0]}
    for name in ("a.feather", "a.arrow"):
        feather.write_feather(pa.table(columns), tmp_path / name, compression="zstd")
        assert read_surface(tmp_path / name).time_ns.tolist() == [0, 100_000_000]
    with pytest.raises(InputError, match=r"a\.arrow: has no column 'TQ'; its columns are: 'time_s'"):
        read_surface(tmp_path / "a.arrow", Layout(torque="TQ"))
    (tmp_path / "b.feather").write_bytes(b"ARROW1 it is not")
    with pytest.raises(InputError, match=r"b\.feather: is no Arrow table"):
        read_surface(tmp_path / "b.feather")
