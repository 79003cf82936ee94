"""Tables of every usual form to sessions and back, as a user types it."""

import subprocess
import sys
from pathlib import Path
from time import sleep

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv
import pyarrow.parquet as parquet
import pytest
from pyarrow import feather
from typer.testing import CliRunner, Result

from tests.rigs import NS, SHORT, samples, simulated
from vsensor.cli.main import app
from vsensor.config import effective_toml
from vsensor.intake import FORECAST_SHED
from vsensor.messages import (
    SENSOR_EVENT,
    SENSOR_TICK,
    SURFACE_BIT_DEPTH,
    SURFACE_HOLE_DEPTH,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Event,
    Sample,
    Tick,
)
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

HEADER = "Date;Time;STOR;RPM\n"
ROWS = ("24.11.2026;08:15:30;10;100", "24.11.2026;08:15:31;12;110", "24.11.2026;08:15:32;14;120")
FORM = (
    *("--date-column", "Date", "--time-column", "Time", "--time-format", "%d.%m.%Y %H:%M:%S"),
    *("--time-zone", "Europe/Oslo", "--torque-column", "STOR", "--torque-unit", "kN*m"),
    *("--speed-column", "RPM", "--speed-unit", "rpm"),
)
BEGUN_NS = 1_795_504_530 * 10**9  # 2026-11-24T07:15:30Z


def vsensor(*words: str | Path) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def torques(session: Path) -> list[tuple[int, float]]:
    return values(session, SURFACE_TORQUE)


def values(session: Path, topic: str) -> list[tuple[int, float]]:
    messages = [record.message for record in Session(session).messages([topic])]
    return [(message.time_ns, message.value) for message in messages if isinstance(message, Sample)]


def test_a_loggers_table_is_imported_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(HEADER + "\n".join(ROWS))
    done = vsensor("import", tmp_path / "log.csv", "-o", tmp_path / "a.mcap", *FORM)
    assert done.exit_code == 0, done.output
    assert "3 rows" in done.output
    assert torques(tmp_path / "a.mcap") == [(BEGUN_NS + k * 10**9, 10e3 + k * 2e3) for k in range(3)]


def test_resampled_only_if_asked_and_said_in_the_session(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(HEADER + "\n".join(ROWS))
    done = vsensor("import", tmp_path / "log.csv", "-o", tmp_path / "a.mcap", *FORM, "--resample", "4 Hz")
    assert done.exit_code == 0, done.output
    told = torques(tmp_path / "a.mcap")
    assert [time_ns - BEGUN_NS for time_ns, _ in told] == [k * 250_000_000 for k in range(9)]
    assert [value for _, value in told] == pytest.approx(np.linspace(10e3, 14e3, 9).tolist())
    assert Session(tmp_path / "a.mcap").metadata["resampled_to"] == "4 Hz"


def test_depths_come_along_once_a_second_and_tare_the_sensor(tmp_path: Path) -> None:
    """Of rows at 50 Hz; a depth that is told seldom is told as often as it is."""
    readings = simulated(12)
    count = len(readings)
    feet = np.full(count, 3937.0)
    seldom = [4000.0 if row % 70 == 10 else None for row in range(count)]
    columns = {
        "time_s": [reading.time_s for reading in readings],
        "motor_torque_nm": [reading.motor_torque for reading in readings],
        "motor_speed_rad_s": [reading.motor_speed for reading in readings],
        "DBTM": feet,
        "DMEA": seldom,
    }
    (tmp_path / "rig.toml").write_text(effective_toml(SHORT))
    arrow_csv.write_csv(pa.table(columns), tmp_path / "log.csv")
    depths = ("--bit-depth-column", "DBTM", "--hole-depth-column", "DMEA", "--depth-unit", "ft")
    done = vsensor("import", tmp_path / "log.csv", "-o", tmp_path / "a.mcap", *depths)
    assert done.exit_code == 0, done.output
    told = {topic: values(tmp_path / "a.mcap", topic) for topic in (SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH)}
    assert [time_ns // NS for time_ns, _ in told[SURFACE_BIT_DEPTH]] == list(range(13))
    assert [value for _, value in told[SURFACE_BIT_DEPTH]] == pytest.approx([3937.0 * 0.3048] * 13)
    assert [time_ns for time_ns, _ in told[SURFACE_HOLE_DEPTH]] == [
        round(readings[row].time_s * NS) for row in range(10, count, 70)
    ]
    done = vsensor("estimate", tmp_path / "a.mcap", tmp_path / "rig.toml", "-o", tmp_path / "b.mcap")
    assert done.exit_code == 0, done.output
    ticks = [record.message for record in Session(tmp_path / "b.mcap").messages([SENSOR_TICK])]
    assert any(tick.off_bottom for tick in ticks if isinstance(tick, Tick)), "20 m off bottom"


def test_a_table_that_is_bad_further_down_leaves_no_session(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(HEADER + "\n".join((*ROWS, "24.11.2026;8h15;1;1")))
    done = vsensor("import", tmp_path / "log.csv", "-o", tmp_path / "a.mcap", *FORM)
    assert done.exit_code == 1
    assert "line 5: Time is '24.11.2026 8h15'" in " ".join(done.output.split())
    assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


def test_the_same_estimates_come_of_every_kind_of_table(tmp_path: Path) -> None:
    """From CSV, Parquet, Feather and an Arrow stream, and of a session made of them; to Parquet and NumPy."""
    readings = simulated(4)
    columns = {
        "time_s": [reading.time_s for reading in readings],
        "motor_torque_nm": [reading.motor_torque for reading in readings],
        "motor_speed_rad_s": [reading.motor_speed for reading in readings],
    }
    table = pa.table(columns)
    (tmp_path / "rig.toml").write_text(effective_toml(SHORT))
    arrow_csv.write_csv(table, tmp_path / "in.csv")
    parquet.write_table(table, tmp_path / "in.parquet")
    feather.write_feather(table, tmp_path / "in.feather")
    with (
        pa.OSFile(str(tmp_path / "in.arrows"), "wb") as file,
        pa.ipc.new_stream(file, table.schema) as stream,
    ):
        stream.write_table(table, max_chunksize=70)
    done = vsensor("import", tmp_path / "in.csv", "-o", tmp_path / "in.mcap")
    assert done.exit_code == 0, done.output
    found = []
    for kind in ("csv", "parquet", "feather", "arrows", "mcap"):
        for output in (tmp_path / f"{kind}.parquet", tmp_path / f"{kind}.npz"):
            done = vsensor("estimate", tmp_path / f"in.{kind}", tmp_path / "rig.toml", "-o", output)
            assert done.exit_code == 0, done.output
        with np.load(tmp_path / f"{kind}.npz") as arrays:
            found.append({name: arrays[name].tobytes() for name in arrays.files})
            speeds = arrays["now_speed_rad_s"]
        told = parquet.read_table(tmp_path / f"{kind}.parquet")["now_speed_rad_s"]
        assert np.array_equal(told.to_numpy(), speeds, equal_nan=True)
        assert np.isfinite(speeds).any()
    assert all(each == found[0] for each in found)


def test_a_hole_in_one_channel_is_a_silence_and_the_table_comes_back_as_it_was(tmp_path: Path) -> None:
    """Torque is missing for a second, speed in every second row: as a table, as a session, as its export."""
    readings = simulated(6)
    rows = [(reading.time_s, reading.motor_torque, reading.motor_speed) for reading in readings]
    cells = [
        f"{time},{'' if 4 <= time < 5 else torque},{'' if number % 2 else speed}"
        for number, (time, torque, speed) in enumerate(rows)
    ]
    (tmp_path / "in.csv").write_text("\n".join(["time_s,motor_torque_nm,motor_speed_rad_s", *cells]))
    (tmp_path / "rig.toml").write_text(effective_toml(SHORT))
    for step in (
        ("import", "in.csv", "-o", "in.mcap", "--config", "rig.toml"),
        ("export", "in.mcap", "--surface", "-o", "again.csv"),
        *(
            ("estimate", name, "rig.toml", "-o", f"{name}.parquet")
            for name in ("in.csv", "in.mcap", "again.csv")
        ),
    ):
        done = vsensor(step[0], *(tmp_path / word if "." in word else word for word in step[1:]))
        assert done.exit_code == 0, done.output
    first, *others = (
        parquet.read_table(tmp_path / f"{name}.parquet") for name in ("in.csv", "in.mcap", "again.csv")
    )
    assert all(other.equals(first) for other in others)
    time, quality = first["time_s"].to_numpy(), np.array(first["quality"].to_pylist())
    assert set(quality[(time > 3) & (time < 3.9)]) == {"good"}
    assert set(quality[(time > 4.02) & (time < 4.9)]) == {"uncertain"}
    counts = Session(tmp_path / "in.mcap").summary().topics
    assert {topic.topic: topic.messages for topic in counts} == {
        SURFACE_TORQUE: len(rows) - sum(4 <= time < 5 for time, *_ in rows),
        SURFACE_SPEED: -(-len(rows) // 2),
    }


def test_where_the_estimates_cannot_go_is_told_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(effective_toml(SHORT))
    (tmp_path / "folder.csv").mkdir()
    for output, status, said in (
        ("missing/x.csv", 1, "missing/x.csv: cannot be written: No such file or directory"),
        ("folder.csv", 1, "folder.csv: cannot be written: Is a directory"),
        ("x.txt", 2, "x.txt: estimates go into .csv, .parquet, .npz or .mcap"),
    ):
        done = vsensor("estimate", tmp_path / "none.csv", tmp_path / "rig.toml", "-o", tmp_path / output)
        assert done.exit_code == status
        assert said in done.output.replace("\n", "")


def test_what_was_refused_is_said_and_a_wrong_unit_guessed(tmp_path: Path) -> None:
    readings = simulated(3)
    torque = [reading.motor_torque for reading in readings]
    rpm = [120.0 + reading.motor_speed for reading in readings]
    (tmp_path / "rig.toml").write_text(effective_toml(SHORT))
    for name, speeds in (("rpm", rpm), ("one", [1e3, *(reading.motor_speed for reading in readings[1:])])):
        columns = {
            "time_s": [r.time_s for r in readings],
            "motor_torque_nm": torque,
            "motor_speed_rad_s": speeds,
        }
        arrow_csv.write_csv(pa.table(columns), tmp_path / f"{name}.csv")
    outputs = [tmp_path / "bit.csv", tmp_path / "bit.mcap"]
    for output in outputs:
        said = vsensor("estimate", tmp_path / "one.csv", tmp_path / "rig.toml", "-o", output).output
        assert f"1 of {len(readings)} samples of surface/speed were refused: out of range 1" in said
        assert "surface/torque" not in said
        assert "unit" not in said
    said = vsensor("estimate", tmp_path / "rpm.csv", tmp_path / "rig.toml", "-o", outputs[0]).output
    assert "is the unit right?" in said


def test_estimate_takes_rows_as_they_come_and_refuses_them_singly(tmp_path: Path) -> None:
    rows = [f"{r.time_s:.2f},{r.motor_torque!r},{r.motor_speed!r}" for r in simulated(4)]
    header = "time_s,motor_torque_nm,motor_speed_rad_s"
    rows[120] = rows[120].rpartition(",")[0] + ",inf"
    rows[140:142] = rows[141], rows[140]
    rows.insert(160, rows[159])
    (tmp_path / "log.csv").write_text("\n".join((header, *rows)))
    (tmp_path / "rig.toml").write_text(effective_toml(SHORT))
    done = vsensor("estimate", tmp_path / "log.csv", tmp_path / "rig.toml", "-o", tmp_path / "bit.parquet")
    assert done.exit_code == 0, done.output
    assert "surface/torque were refused: doubled 1, late 1" in done.output
    assert "surface/speed were refused: not finite 1, doubled 1, late 1" in done.output
    assert len(parquet.read_table(tmp_path / "bit.parquet")) == len(rows) - 1
    done = vsensor("import", tmp_path / "log.csv", "-o", tmp_path / "a.mcap")
    assert "line 143: time_s is 2.82 s after 2.84 s" in done.output


def test_without_the_forecast_all_else_stays_the_same(tmp_path: Path) -> None:
    """From a table and from a session whose sensor had shed its forecast for a while; into either."""
    feed = samples(simulated(6))
    shed = [(SENSOR_EVENT, Event(name=FORECAST_SHED, begins=begins)) for begins in (True, False)]
    with SessionWriter(
        tmp_path / "in.mcap", configuration=effective_toml(SHORT), metadata={"rig": "r"}, compression="zstd"
    ) as writer:
        for topic, message in [*feed[:800], shed[0], *feed[800:900], shed[1], *feed[900:]]:
            writer.write(topic, message.SerializeToString(), 0, 0)
    for name, option in (("whole", "--forecast"), ("less", "--no-forecast")):
        for kind in ("parquet", "mcap"):
            done = vsensor("estimate", tmp_path / "in.mcap", option, "-o", tmp_path / f"{name}.{kind}")
            assert done.exit_code == 0, done.output
    whole, less = (parquet.read_table(tmp_path / f"{name}.parquet") for name in ("whole", "less"))
    for name in whole.column_names:
        if name.startswith("forecast"):
            assert whole[name].null_count < len(whole)
            assert less[name].null_count == len(less)
        else:
            assert less[name].equals(whole[name]), name
    assert vsensor("verify", tmp_path / "less.mcap").output.count("exact") == 1
    assert vsensor("export", tmp_path / "less.mcap", "-o", tmp_path / "again.parquet").exit_code == 0
    assert parquet.read_table(tmp_path / "again.parquet").equals(less)


@pytest.mark.process
def test_an_import_that_is_terminated_leaves_nothing_behind(tmp_path: Path) -> None:
    rows = 300_000
    time = 1.7e9 + 0.01 * np.arange(rows)
    columns = {"time_s": time, "motor_torque_nm": np.full(rows, 9e3), "motor_speed_rad_s": np.full(rows, 8.0)}
    parquet.write_table(pa.table(columns), tmp_path / "long.parquet")
    words = [sys.executable, "-m", "vsensor.cli.main", "import", "long.parquet", "-o", "long.mcap"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as running:
        while running.poll() is None and not (tmp_path / "long.mcap.part").exists():
            sleep(0.01)
        running.terminate()
        _, said = running.communicate()
    assert (running.returncode, said) == (143, "")
    assert [path.name for path in tmp_path.iterdir()] == ["long.parquet"]
