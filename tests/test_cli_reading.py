"""The bar of a command that reads a file: it follows the reading without the reader's doing."""

import io
from pathlib import Path

import pytest
from rich.console import Console

from tests.daemons import wait_until
from vsensor.cli.reading import place, reading

SIZE = 1000


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "[a] session.mcap"
    path.write_bytes(bytes(SIZE))
    return path


def test_how_far_a_file_is_read_is_known_while_it_is_open(source: Path) -> None:
    assert place(source) == 0
    with io.FileIO(source) as file:
        assert place(source) == 0
        file.read(300)
        assert place(source) == 300
    assert place(source) == 0


def test_the_bar_shows_it_and_leaves_nothing_behind(source: Path) -> None:
    drawn = io.StringIO()
    with (
        reading(source, "reading", Console(file=drawn, force_terminal=True, width=80)),
        io.FileIO(source) as file,
    ):
        file.seek(SIZE // 5)
        wait_until(lambda: "20%" in drawn.getvalue(), "a fifth")
        file.seek(SIZE // 4 * 3)
        wait_until(lambda: "75%" in drawn.getvalue(), "three quarters")
    assert "reading [a] session.mcap" in drawn.getvalue()
    assert drawn.getvalue().rstrip().endswith("\x1b[2K"), "the line is wiped"


def test_in_a_pipe_there_is_none(source: Path) -> None:
    drawn = io.StringIO()
    with reading(source, "reading", Console(file=drawn)):
        pass
    assert drawn.getvalue() == ""
