"""What the player says above its line: which session begins, after what gap, however fast they go by."""

import io
from pathlib import Path

import pytest
from rich.console import Console

from tests.test_recording_replay import NS, write
from vsensor.cli.screen import Screen
from vsensor.messages import SURFACE_TOPICS
from vsensor.recording.course import Course
from vsensor.recording.player import Progress
from vsensor.recording.reader import Session

ROWS = 50
BEGUN_S = 1000.0, 1090.0, 1091.0
"""Half a second each, the first two a minute and a half apart."""


@pytest.fixture
def course(tmp_path: Path) -> Course:
    paths = [tmp_path / f"{name}.mcap" for name in "abc"]
    for path, begun_s in zip(paths, BEGUN_S, strict=True):
        write(path, ROWS, begun_ns=round(begun_s * NS))
    return Course([Session(path) for path in paths], SURFACE_TOPICS, 10.0)


def said(course: Course, *positions_s: float) -> list[str]:
    """What stands above the line in the end, the player having been at these positions in turn."""
    console = Console(file=io.StringIO(), force_terminal=False)
    with Screen(console, course, "rigs/well-b", 1.0, keys=False) as screen:
        for position_s in positions_s:
            screen.show(Progress(position_s, 0, paused=False))
    assert isinstance(console.file, io.StringIO)
    return [line.rpartition("/")[2] for line in console.file.getvalue().splitlines() if line]


def test_one_session_is_not_announced(course: Course) -> None:
    assert said(course, 0.0, 0.2) == []


def test_sessions_that_go_by_between_two_looks_are_said_each_with_its_gap(course: Course) -> None:
    end_s = course.length_ns / NS
    whole = ["b.mcap, after a gap of 1:29.5", "c.mcap, goes on from there"]
    assert said(course, 0.0, end_s) == whole
    assert said(course, end_s) == whole


def test_one_that_is_gone_back_to_is_named(course: Course) -> None:
    screened = said(course, course.length_ns / NS, 0.0)
    assert screened[-1] == "a.mcap"
