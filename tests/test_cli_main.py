"""The command line as a whole: help, version, errors as messages with an exit status."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import vsensor
from vsensor.cli import check, main
from vsensor.errors import VsensorError


def test_every_command_is_listed_and_can_be_loaded() -> None:
    result = CliRunner().invoke(main.app, ["--help"])
    assert result.exit_code == 0
    for name in main.COMMANDS:
        assert f" {name} " in result.output
        assert CliRunner().invoke(main.app, [name, "--help"]).exit_code == 0


def test_version() -> None:
    result = CliRunner().invoke(main.app, ["--version"])
    assert (result.exit_code, result.output) == (0, f"vsensor {vsensor.__version__}\n")


@pytest.mark.parametrize("arguments", [[], ["chekc"], ["check"], ["check", "x", "--nope"]])
def test_wrong_use_is_status_2(arguments: list[str]) -> None:
    assert CliRunner().invoke(main.app, arguments).exit_code == 2


def test_a_slip_of_the_finger_gets_a_suggestion() -> None:
    assert "Did you mean 'check'?" in CliRunner().invoke(main.app, ["chekc"]).output


def test_a_faulty_configuration_is_told_on_stderr_with_status_2(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text("rig.name = 'x'\nstring = []\n[loop]\nrate = 0")
    result = CliRunner().invoke(main.app, ["check", str(file)])
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.startswith(f"error: {file}: 2 faults\n  string = []: must not be empty")
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize(
    ("raised", "status"),
    [(VsensorError("the work failed"), 1), (KeyboardInterrupt(), 130)],
    ids=["error", "ctrl-c"],
)
def test_what_ends_a_command_becomes_its_status(
    monkeypatch: pytest.MonkeyPatch, raised: BaseException, status: int
) -> None:
    def fail(_path: Path) -> None:
        raise raised

    monkeypatch.setattr(check, "load", fail)
    result = CliRunner().invoke(main.app, ["check", "any.toml"])
    assert result.exit_code == status
    assert result.output == (f"error: {raised}\n" if str(raised) else "")


PROGRAM = (sys.executable, "-m", "vsensor.cli.main")


@pytest.mark.process
@pytest.mark.parametrize("words", [["--version"], ["--help"], ["info", "recordings/stick_slip.mcap"]])
def test_where_standard_output_takes_no_more_one_line_says_so(words: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run([*PROGRAM, *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    told = "error: standard output: cannot be written: No space left on device\n"
    assert (done.returncode, done.stderr) == (1, told)


@pytest.mark.process
def test_a_terminal_without_our_letters_shows_question_marks() -> None:
    told = subprocess.run(
        [*PROGRAM, "check", "config/drilling.toml"],
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "N?m" in told.stdout


@pytest.mark.process
def test_who_reads_no_further_than_the_first_line_is_told_of_no_error() -> None:
    with subprocess.Popen(
        [*PROGRAM, "check", "config/drilling.toml"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        process.stdout.close()
        _, told = process.communicate(timeout=60)
    assert (process.returncode, told) == (1, "")


@pytest.mark.process
@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["info", "recordings/stick_slip.mcap"], 0, ""),
        (["status", "config/drilling.toml", "--connect", "tcp/127.0.0.1:1"], 1, "error: no bus at"),
        (["run", "CONFIG"], 1, "error: "),
    ],
)
def test_without_standard_streams_the_work_is_done_all_the_same(
    tmp_path: Path, words: list[str], status: int, said: str
) -> None:
    """As under a supervisor that closes it."""
    taken = tmp_path / "rig.toml"
    taken.write_text(Path("config/drilling.toml").read_text() + '[bus]\nlisten = ["tcp/192.0.2.1:7447"]\n')
    command = shlex.join([*PROGRAM, *(str(taken) if word == "CONFIG" else word for word in words)])
    shut = ["sh", "-c", f"exec {command} <&- >&-"]
    done = subprocess.run(shut, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr.startswith(said)) == (status, True), done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.process
def test_no_file_takes_the_place_of_a_closed_stream() -> None:
    """For what is said there, by whichever library, would be written into it."""
    program = """
import os, sys
from vsensor.cli.output import Output, open_closed
open_closed()
sys.stdout = Output.standard()
taken = os.open("/proc/self/status", os.O_RDONLY)
held = [os.readlink(f"/proc/self/fd/{number}") == os.devnull for number in range(3)]
sys.stdin.read(), sys.stdout.write("lost"), sys.stderr.write("lost")
sys.exit(7 if all(held) and all(map(os.get_inheritable, range(3))) and taken > 2 else 1)
"""
    shut = f"exec {shlex.join([sys.executable, '-c', program])} <&- >&- 2>&-"
    assert subprocess.run(["sh", "-c", shut], check=False).returncode == 7


@pytest.mark.process
def test_help_loads_none_of_the_heavy_libraries() -> None:
    """What keeps `vsensor --help` quick."""
    program = """
import sys
from vsensor.cli.main import main
sys.argv = ["vsensor", "--help"]
try:
    main()
except SystemExit as end:
    heavy = {"zenoh", "rerun", "numba", "pyarrow", "numpy", "mcap", "pint", "pydantic"} & sys.modules.keys()
    print("heavy:", *sorted(heavy))
    sys.exit(end.code)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "heavy:"
