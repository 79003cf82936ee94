"""The commands that make, read, mend and play sessions, as a user meets them."""

import errno
import os
from collections.abc import Sequence
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from vsensor.cli.main import app
from vsensor.config import loads
from vsensor.messages import (
    BIT_ESTIMATE,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Estimate,
    Sample,
)
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

CONFIG = """
[rig]
name = "rig-7"
[[string]]
length = "1000 m"
outer_diameter = "5 in"
inner_diameter = "4.276 in"
"""


def vsensor(*words: str | Path) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def surface_csv(path: Path, rows: int = 200) -> Path:
    lines = [f"{n / 100},{n * 10},{n / 10}\n" for n in range(rows)]
    path.write_text("time_s,motor_torque_nm,motor_speed_rad_s\n" + "".join(lines))
    return path


@pytest.fixture
def session(tmp_path: Path) -> Path:
    done = vsensor("import", surface_csv(tmp_path / "a.csv"), "-o", tmp_path / "a.mcap", "--rig", "well-b")
    assert done.exit_code == 0, done.output
    return tmp_path / "a.mcap"


def test_import_makes_a_session_of_a_table(session: Path) -> None:
    read = Session(session)
    messages = list(read.messages())
    assert len(messages) == 400
    assert [m.topic for m in messages[:4]] == [SURFACE_TORQUE, SURFACE_SPEED] * 2
    assert messages[2].message == Sample(time_ns=10_000_000, value=10.0, sequence=1)
    assert messages[2].log_time_ns == messages[2].publish_time_ns == 10_000_000
    assert read.metadata["rig"] == "well-b"
    assert read.configuration is None


def test_import_attaches_the_configuration_and_takes_names_and_units(tmp_path: Path) -> None:
    """Of an editor that begins a file with a mark of its byte order, too."""
    (tmp_path / "rig.toml").write_text(CONFIG, encoding="utf-8-sig")
    (tmp_path / "a.csv").write_text("t,TQ,RPM\n10,2,30\n20,4,60\n")
    columns = ("--time-column", "t", "--torque-column", "TQ", "--speed-column", "RPM")
    units = ("--time-unit", "ms", "--torque-unit", "kN*m", "--speed-unit", "rpm")
    files = (tmp_path / "a.csv", "-o", tmp_path / "a.mcap", "--config", tmp_path / "rig.toml")
    done = vsensor("import", *files, *columns, *units)
    assert done.exit_code == 0, done.output
    read = Session(tmp_path / "a.mcap")
    assert loads(read.configuration or "", "a.mcap") == loads(CONFIG, "rig.toml")
    assert read.metadata["rig"] == "rig-7"
    first, speed, *_ = (record.message for record in read.messages())
    assert first == Sample(time_ns=10_000_000, value=2000.0, sequence=0)
    assert isinstance(speed, Sample)
    assert speed.value == pytest.approx(3.14159, rel=1e-5)


def test_export_of_the_surface_gives_the_table_back(session: Path, tmp_path: Path) -> None:
    done = vsensor("export", session, "-o", tmp_path / "b.csv", "--surface")
    assert (done.exit_code, "200 rows" in done.output) == (0, True)
    header, *back = (tmp_path / "b.csv").read_text().splitlines()
    header_sent, *sent = (tmp_path / "a.csv").read_text().splitlines()
    assert header == f"{header_sent},time_ns"
    assert [[float(text) for text in row.split(",")[:3]] for row in back] == [
        [float(text) for text in row.split(",")] for row in sent
    ]


def test_export_gives_the_recorded_estimates(tmp_path: Path) -> None:
    with SessionWriter(tmp_path / "a.mcap", configuration="", metadata={}, compression="zstd") as writer:
        estimate = Estimate(number=0, time_ns=10_000_000, now_bit_speed_rad_s=2.5, quality=1)  # type: ignore[arg-type]
        writer.write(BIT_ESTIMATE, estimate.SerializeToString(), 0, 0)
    assert vsensor("export", tmp_path / "a.mcap", "-o", tmp_path / "b.csv").exit_code == 0
    row = (tmp_path / "b.csv").read_text().splitlines()[1]
    assert row == "0.01,,,,,,2.5" + "," * 9 + "good"


def test_export_says_where_one_channel_stands_alone(tmp_path: Path) -> None:
    with SessionWriter(tmp_path / "a.mcap", configuration="", metadata={}, compression="zstd") as writer:
        writer.write(SURFACE_TORQUE, Sample(time_ns=0, value=1).SerializeToString(), 0, 0)
    done = vsensor("export", tmp_path / "a.mcap", "-o", tmp_path / "b.csv", "--surface")
    assert "1 rows have a sample of one channel alone" in done.output
    assert (tmp_path / "b.csv").read_text().splitlines()[1] == "0,1,,0"


def test_info_tells_what_is_in_it(session: Path) -> None:
    done = vsensor("info", session)
    assert done.exit_code == 0
    said = [" ".join(line.split()) for line in done.output.splitlines()]
    assert "state complete" in said
    assert "rig well-b" in said
    assert "messages 400" in said
    assert "surface/torque 200 100 Hz 0.000 s 1.990 s" in said


@pytest.mark.parametrize("window", [{}, {"FORCE_COLOR": "1"}], ids=["a pipe", "a terminal"])
def test_in_a_narrow_window_no_figure_is_cut_short(session: Path, window: dict[str, str]) -> None:
    narrow = CliRunner(env=window | {"COLUMNS": "40", "NO_COLOR": "1"})
    said = narrow.invoke(app, ["info", str(session)]).output
    assert "…" not in said
    assert "surface/torque" in said
    told = narrow.invoke(app, ["check", "config/drilling.toml"]).output
    assert "…" not in told
    assert "2500.00" in told


def test_nothing_that_a_session_tells_is_obeyed_by_a_terminal(tmp_path: Path) -> None:
    metadata = {"rig": "a\x1b]0;title\x07", "\x1b[2J": "x"}
    with SessionWriter(tmp_path / "a.mcap", configuration="", metadata=metadata, compression="none"):
        pass
    said = CliRunner(env={"FORCE_COLOR": "1", "NO_COLOR": "1"}).invoke(
        app, ["info", str(tmp_path / "a.mcap")]
    )
    assert r"a\x1b]0;title\x07" in said.output
    assert r"\x1b[2J" in said.output
    assert not any(letters in said.output for letters in ("\x07", "\x1b]", "\x1b[2J"))


def test_info_of_a_torn_session_says_so_and_recover_mends_it(session: Path) -> None:
    torn = session.with_name("b.mcap.part")
    torn.write_bytes(session.read_bytes()[:-20])
    assert "torn, damaged or still being written" in vsensor("info", torn).output

    done = vsensor("recover", torn)

    assert (done.exit_code, "400 messages recovered into" in done.output) == (0, True)
    assert len(list(Session(session.with_name("b.mcap")).messages())) == 400


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (("import", "no.csv", "-o", "x.mcap"), 1, "no.csv: cannot be read"),
        (("import", "a.csv", "-o", "x.csv"), 2, "must end in .mcap"),
        (("import", "a.csv", "-o", "a.mcap"), 1, "a.mcap: exists already"),
        (("import", "a.csv", "-o", "x.mcap", "--torque-unit", "rpm"), 2, "no unit for motor_torque_nm"),
        (("import", "a.csv", "-o", "x.mcap", "--torque-column", "TQ"), 1, "no column 'TQ'"),
        (("import", "a.csv"), 2, "--output"),
        (("import", "a.csv", "-o", "x.mcap", "--time-zone", "Mars"), 2, "'Mars' is no time zone"),
        (("import", "a.csv", "-o", "x.mcap", "--rig", "a/b"), 2, "letters, digits and . _ -"),
        (("replay", "star.mcap"), 2, "star.mcap: the recorded rig: 1 fault name = '**'"),
        (("view", "--session", "a.mcap", "--save", "a.mcap"), 2, "--save a.mcap: must end in .rrd"),
        (("simulate", "rig.toml", "--truth", "rig.toml"), 2, "--truth rig.toml: must end in .csv"),
        (("estimate", "a.csv", "rig.toml", "-o", "a.csv"), 2, "a.csv: is what is read"),
        (("estimate", "rig.toml", "-o", "x.csv"), 2, "rig.toml: a table's name must end in .csv"),
        (("check", "windows.toml"), 2, "windows.toml, line 2: is not UTF-8: save it as UTF-8"),
        (("check", "no.toml"), 2, "no.toml: cannot be read: No such file or directory"),
        (("export", "a.mcap", "-o", "x.csv"), 1, "holds no bit/estimate; --surface"),
        (("export", "a.mcap", "--surface", "-o", "x.txt"), 2, "must end in .csv or .parquet"),
        (("export", "a.csv", "-o", "x.csv"), 1, "is no MCAP file"),
        (("info", "a.csv"), 1, "is no MCAP file"),
        (("recover", "a.csv"), 1, "is no MCAP file"),
        (("replay", "a.csv"), 1, "is no MCAP file"),
        (("replay", "a.mcap", "--speed", "0"), 2, "--speed"),
        (("replay", "a.mcap", "--connect", "tcp/127.0.0.1:1"), 1, "no bus at tcp/127.0.0.1:1"),
    ],
)
def test_wrong_use_is_explained(
    session: Path, monkeypatch: pytest.MonkeyPatch, words: Sequence[str], status: int, said: str
) -> None:
    monkeypatch.chdir(session.parent)
    Path("rig.toml").write_text(CONFIG)
    Path("windows.toml").write_text("[rig]\nname = 'Bohrloch-Süd'\n", encoding="latin-1")
    star = SessionWriter(Path("star.mcap"), configuration="", metadata={"rig": "**"}, compression="none")
    with star as writer:
        writer.write(SURFACE_TORQUE, Sample(time_ns=0, value=1).SerializeToString(), 0, 0)
    before = {path.name: path.read_bytes() for path in session.parent.iterdir()}
    done = vsensor(*words)
    assert done.exit_code == status
    assert said in " ".join(done.output.split())
    assert {path.name: path.read_bytes() for path in session.parent.iterdir()} == before


def test_replay_asks_for_the_rig_where_nothing_says_it(tmp_path: Path) -> None:
    vsensor("import", surface_csv(tmp_path / "a.csv"), "-o", tmp_path / "a.mcap")
    done = vsensor("replay", tmp_path / "a.mcap")
    assert done.exit_code == 2
    assert "name one with --rig" in done.output


@pytest.mark.parametrize("color", ["", "1"], ids=["a pipe", "a terminal"])
@pytest.mark.parametrize(
    "words",
    [
        ("info", "NAME.mcap"),
        ("check", "NAME.toml"),
        ("recover", "NAME.mcap"),
        ("estimate", "NAME.mcap", "NAME.toml", "-o", "NAME.csv"),
        ("export", "NAME.mcap", "--surface", "-o", "NAME.csv"),
        ("import", "a.csv", "-o", "NAME2.mcap"),
        ("verify", "NAME.mcap", "--config", "NAME.toml"),
    ],
)
def test_names_are_shown_as_they_are(
    session: Path, monkeypatch: pytest.MonkeyPatch, words: Sequence[str], color: str
) -> None:
    """Whatever stands in brackets, which would be a style to who prints it."""
    monkeypatch.chdir(session.parent)
    monkeypatch.setenv("FORCE_COLOR", color)
    monkeypatch.setenv("NO_COLOR", "1")
    Path("[").mkdir()
    session.rename("[/bold][red]a.mcap")
    Path("[/bold][red]a.toml").write_text(CONFIG)
    done = vsensor(*(word.replace("NAME", "[/bold][red]a") for word in words))
    assert isinstance(done.exception, SystemExit | None)
    assert "[/bold][red]a" in done.output


@pytest.mark.parametrize("ending", ["mcap.part", "MCAP", "mcap.torn"])
def test_estimates_are_made_of_a_session_that_is_torn_or_named_in_capitals(
    session: Path, tmp_path: Path, ending: str
) -> None:
    (tmp_path / "rig.toml").write_text(CONFIG)
    torn = session.rename(tmp_path / f"b.{ending}")
    done = vsensor("estimate", torn, tmp_path / "rig.toml", "-o", tmp_path / "b.csv")
    assert (done.exit_code, "200 ticks estimated" in done.output) == (0, True), done.output


def test_a_table_that_is_bad_further_down_leaves_no_session_of_estimates(tmp_path: Path) -> None:
    table = surface_csv(tmp_path / "a.csv")
    table.write_text(table.read_text() + "x,1,1\n")
    (tmp_path / "rig.toml").write_text(CONFIG)
    done = vsensor("estimate", table, tmp_path / "rig.toml", "-o", tmp_path / "b.mcap")
    assert (done.exit_code, "line 202" in done.output) == (1, True), done.output
    assert not list(tmp_path.glob("b*"))


@pytest.mark.parametrize("after", [0, 1, 2], ids=["at once", "at the last", "at the index"])
@pytest.mark.parametrize("command", ["import", "estimate"])
def test_a_full_disk_leaves_no_session_of_a_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, after: int
) -> None:
    (tmp_path / "rig.toml").write_text(CONFIG)
    table = surface_csv(tmp_path / "a.csv")
    synced = 0

    def full(_handle: int) -> None:
        nonlocal synced
        synced += 1
        if synced > after:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    rig = [tmp_path / "rig.toml"] if command == "estimate" else []
    done = vsensor(command, table, *rig, "-o", tmp_path / "b.mcap")
    assert done.exit_code == 1
    assert f"{tmp_path / 'b.mcap'}: cannot be written: No space left on device" in done.output.replace(
        "\n", ""
    )
    assert not list(tmp_path.glob("b*"))


def test_another_session_that_is_being_written_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "b.mcap.part").write_bytes(b"another's")
    done = vsensor("import", surface_csv(tmp_path / "a.csv"), "-o", tmp_path / "b.mcap")
    assert (done.exit_code, "b.mcap.part: exists already" in done.output) == (1, True)
    assert (tmp_path / "b.mcap.part").read_bytes() == b"another's"
