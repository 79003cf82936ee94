"""The command line as a whole: help, version, errors as messages with an exit status."""

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
