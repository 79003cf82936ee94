"""What the daemon says: one line an event, for people or for collectors, and never too many."""

import contextlib
import io
import json
import os
import re
import time
from collections.abc import Iterator

import pytest

from vsensor.cli import log as log_module
from vsensor.cli.log import BURST, Form, Writer, logging


def test_logfmt_and_json_bear_time_level_event_and_fields(capsys: pytest.CaptureFixture[str]) -> None:
    with logging(Form.LOGFMT, rig="a") as log:
        log.warning("not recorded", more=3, why='the "disk"\nis full')
    with logging(Form.JSON, rig="a") as log:
        log.error("no longer recorded", why="größer")
    first, second = capsys.readouterr().out.splitlines()
    assert re.fullmatch(
        r'time=20\S+Z level=warning event="not recorded" rig=a more=3 why="the \\"disk\\"\\nis full"', first
    )
    told = json.loads(second)
    assert {key: told[key] for key in ("level", "event", "rig", "why")} == {
        "level": "error",
        "event": "no longer recorded",
        "rig": "a",
        "why": "größer",
    }


def test_text_is_for_people_and_has_no_colours_in_a_file(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with logging(Form.TEXT) as log:
        log.info("state", state="running")
    assert re.fullmatch(r"\d\d:\d\d:\d\d \[info     \] state +state=running\n", capsys.readouterr().out)


@pytest.mark.parametrize("form", Form)
def test_what_others_wrote_is_no_order_to_a_terminal(capsys: pytest.CaptureFixture[str], form: Form) -> None:
    with logging(form) as log:
        log.warning("unreadable", last="\x1b[2Jno\x07\n00:00:00 [info     ] READY")
    told = capsys.readouterr().out
    assert not {"\x1b", "\x07"} & {*told}
    assert len(told.splitlines()) == 1


def test_where_there_is_no_terminal_it_is_logfmt(capsys: pytest.CaptureFixture[str]) -> None:
    with logging() as log:
        log.info("READY")
    assert "event=READY" in capsys.readouterr().out


def test_of_a_kind_that_comes_too_often_some_lines_come_and_the_rest_is_counted(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    now = 10**12
    monkeypatch.setattr(time, "monotonic_ns", lambda: now)
    with logging(Form.JSON) as log:
        for number in range(100):
            log.warning("turns skipped", number=number)
        log.info("state", state="running")
        now += 10**10
        log.warning("turns skipped", number=100)
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["number"] for line in lines if "number" in line] == [*range(BURST), 100]
    assert lines[-1]["suppressed"] == 100 - BURST
    assert lines[-2]["event"] == "state"


@pytest.fixture
def nobody_reads() -> Iterator[io.TextIOWrapper]:
    """A pipe that is full at once, as of a terminal that is held up."""
    reader, writer = os.pipe()
    stream = os.fdopen(writer, "w")
    yield stream
    os.close(reader)
    with contextlib.suppress(BrokenPipeError):  # where something was still to be written
        stream.close()


def test_whoever_logs_never_waits_for_who_does_not_read(
    nobody_reads: io.TextIOWrapper, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_module, "FAREWELL_S", 0.1)
    writer = Writer(nobody_reads)
    for _ in range(2 * log_module.WAITING):
        writer.info("x" * 1000)
    writer.close()
