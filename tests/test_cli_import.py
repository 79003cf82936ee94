"""`vsensor import` of what is not as it should be, and of what `vsensor export` wrote."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from tests.rigs import SHORT, simulated
from vsensor.cli.main import app
from vsensor.config import effective_toml
from vsensor.messages import SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH, SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

HEADER = "time_s,motor_torque_nm,motor_speed_rad_s\n"
TOPICS = (SURFACE_TORQUE, SURFACE_SPEED, SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH)
BEGUN_NS = 1_774_749_590_123_456_789


def vsensor(*words: str | Path) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def imported(folder: Path, text: str, *options: str) -> Result:
    (folder / "log.csv").write_text(text)
    return vsensor("import", folder / "log.csv", "-o", folder / "a.mcap", *options)


def values(session: Path) -> dict[str, list[tuple[int, float]]]:
    found: dict[str, list[tuple[int, float]]] = {}
    for record in Session(session).messages(TOPICS):
        assert isinstance(record.message, Sample)
        found.setdefault(record.topic, []).append((record.message.time_ns, record.message.value))
    return found


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ("--speed-column", "motor_torque_nm"),
            "--torque-column and --speed-column both name 'motor_torque_nm'",
        ),
        (("--time-column", "motor_speed_rad_s"), "--time-column and --speed-column both name"),
        (("--date-column", "time_s"), "--time-column and --date-column both name 'time_s'"),
        (("--bit-depth-column", "time_s"), "--time-column and --bit-depth-column both name 'time_s'"),
        (
            ("--bit-depth-column", "D", "--hole-depth-column", "D"),
            "--bit-depth-column and --hole-depth-column both name 'D'",
        ),
    ],
)
def test_one_column_for_two_is_wrong_use(tmp_path: Path, options: tuple[str, ...], said: str) -> None:
    done = imported(tmp_path, HEADER + "0,1,2\n", *options)
    assert done.exit_code == 2
    assert said in done.stderr


@pytest.mark.parametrize("command", ["import", "estimate"])
def test_what_may_stand_for_no_value_is_said_and_taken_for_none_where_asked(
    tmp_path: Path, command: str
) -> None:
    rows = [f"{r.time_s:.2f},{r.motor_torque!r},{r.motor_speed!r}\n" for r in simulated(3)]
    rows[30] = rows[30].split(",")[0] + ",-999.25,0\n"
    (tmp_path / "log.csv").write_text(HEADER + "".join(rows))
    (tmp_path / "rig.toml").write_text(effective_toml(SHORT))
    rig = [tmp_path / "rig.toml"] if command == "estimate" else []
    words: list[str | Path] = [command, tmp_path / "log.csv", *rig]
    done = vsensor(*words, "-o", tmp_path / "a.mcap")
    assert done.exit_code == 0, done.output
    hint = "1 cell of motor_torque_nm is -999.25: if that stands for no value, --null -999.25"
    assert hint in done.stderr
    assert len(values(tmp_path / "a.mcap")[SURFACE_TORQUE]) == len(rows)
    done = vsensor(*words, "--null", "-9999", "--null", "-999.25", "-o", tmp_path / "b.mcap")
    assert (done.exit_code, done.stderr) == (0, "")
    found = values(tmp_path / "b.mcap")
    assert (len(found[SURFACE_TORQUE]), len(found[SURFACE_SPEED])) == (len(rows) - 1, len(rows))


def test_of_a_session_no_number_stands_for_no_value(tmp_path: Path) -> None:
    session(tmp_path / "a.mcap")
    done = vsensor("estimate", tmp_path / "a.mcap", "--null", "-999", "-o", tmp_path / "b.csv")
    assert (done.exit_code, "--null is for a table" in done.stderr) == (2, True)


def test_a_channel_without_any_value_is_said(tmp_path: Path) -> None:
    done = imported(tmp_path, HEADER + "0,1,\n1,1,\n")
    assert done.exit_code == 0
    assert "motor_speed_rad_s has no value at all" in done.stderr


def test_of_two_empty_channels_no_session_is_made(tmp_path: Path) -> None:
    done = imported(tmp_path, HEADER + "0,,\n1,,\n")
    assert done.exit_code == 1
    assert "neither motor_torque_nm nor motor_speed_rad_s has any value" in done.stderr
    assert not (tmp_path / "a.mcap").exists()


def test_times_before_a_sessions_clock_are_refused(tmp_path: Path) -> None:
    done = imported(tmp_path, HEADER + "-1.5,1,2\n0,1,2\n")
    assert done.exit_code == 1
    assert "line 2: time_s is -1.5 s: a session's times begin with 0" in done.stderr


def test_lines_before_the_header_and_one_of_units(tmp_path: Path) -> None:
    text = "Well: A-1\n\ntime_s,motor_torque_nm,motor_speed_rad_s\ns,kN.m,r/min\n0,2,60\n"
    done = imported(tmp_path, text, "--skip-lines", "2", "--units-line")
    assert done.exit_code == 0, done.output
    assert values(tmp_path / "a.mcap") == {
        SURFACE_TORQUE: [(0, 2000.0)],
        SURFACE_SPEED: [(0, pytest.approx(2 * np.pi))],
    }


def session(path: Path) -> None:
    """Torque and speed at times of their own, depths now and then, and all of it in more than one chunk."""
    random = np.random.default_rng(1)
    steps_ns = {SURFACE_TORQUE: 9_999_937, SURFACE_SPEED: 19_999_999}
    steps_ns |= {SURFACE_BIT_DEPTH: 400_000_000, SURFACE_HOLE_DEPTH: 5_000_000_001}
    told: list[tuple[int, str, Any]] = []
    for topic, step_ns in steps_ns.items():
        for number in range(12_000_000_000 // step_ns):
            time_ns = BEGUN_NS + number * step_ns
            told.append((time_ns, topic, Sample(time_ns=time_ns, value=random.normal())))
    with SessionWriter(path, configuration="", metadata={"rig": "r"}, compression="none") as writer:
        for number, (time_ns, topic, sample) in enumerate(sorted(told, key=lambda each: each[:2])):
            if number % 500 == 0:
                writer.sync()
            writer.write(topic, sample.SerializeToString(), time_ns, time_ns)


@pytest.mark.parametrize("kind", ["csv", "parquet", "npz"])
def test_what_is_exported_is_imported_to_the_same_samples(tmp_path: Path, kind: str) -> None:
    session(tmp_path / "a.mcap")
    table = tmp_path / f"a.{kind}"
    done = vsensor("export", tmp_path / "a.mcap", "--surface", "-o", table)
    assert done.exit_code == 0, done.output
    done = vsensor("import", table, "-o", tmp_path / "b.mcap")
    assert (done.exit_code, done.stderr) == (0, "")
    found, told = values(tmp_path / "b.mcap"), values(tmp_path / "a.mcap")
    assert set(told) == set(TOPICS)
    assert found == told


def test_a_table_of_a_session_without_depths_has_no_columns_of_them(tmp_path: Path) -> None:
    imported(tmp_path, HEADER + "0.5,1,2\n")
    assert vsensor("export", tmp_path / "a.mcap", "--surface", "-o", tmp_path / "b.csv").exit_code == 0
    assert (tmp_path / "b.csv").read_text() == HEADER.replace("\n", ",time_ns\n") + "0.5,1,2,500000000\n"


def test_estimate_takes_the_exact_time_too(tmp_path: Path) -> None:
    """Seconds since 1970 as doubles are off by up to 119 ns."""
    (tmp_path / "rig.toml").write_text(effective_toml(SHORT))
    rows = [
        f"{BEGUN_NS + k * 20_000_000},{r.motor_torque!r},{r.motor_speed!r}\n"
        for k, r in enumerate(simulated(2))
    ]
    imported(tmp_path, HEADER.replace("time_s", "time_ns") + "".join(rows))
    assert vsensor("export", tmp_path / "a.mcap", "--surface", "-o", tmp_path / "b.parquet").exit_code == 0
    found = []
    for source in ("a.mcap", "b.parquet"):
        output = tmp_path / f"{source}.again.mcap"
        done = vsensor("estimate", tmp_path / source, tmp_path / "rig.toml", "-o", output)
        assert done.exit_code == 0, done.output
        found.append(values(output))
    assert found[0] == found[1]
    assert found[0][SURFACE_TORQUE][0][0] == BEGUN_NS
