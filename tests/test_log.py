"""What the daemon says: one line an event, for people or for collectors, and never too many."""

import contextlib
import io
import json
import os
import re
import sys
import threading
import time
from collections.abc import Iterator
from datetime import datetime

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
    writer = Writer(nobody_reads, str)
    for number in range(2 * log_module.WAITING):
        writer.info({"event": f"{number}", "text": "x" * 1000})
    writer.close()


def said(capsys: pytest.CaptureFixture[str]) -> list[dict[str, object]]:
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_lines_that_nobody_read_are_told_in_the_next(capsys: pytest.CaptureFixture[str]) -> None:
    with logging(Form.JSON, rig="a") as log:
        hold_up = threading.Event()
        sys.stdout.flush = lambda: hold_up.wait(10)  # type: ignore[method-assign]
        for number in range(2 * log_module.WAITING):
            log.info(f"event {number}")
        del sys.stdout.flush
        hold_up.set()
        time.sleep(0.5)  # there is room again
        log.info("after it")
    lines = said(capsys)
    assert lines[-1]["event"] == "after it"
    dropped = sum(int(str(line.get("lines_dropped", 0))) for line in lines)
    assert dropped == 2 * log_module.WAITING - (len(lines) - 1)


def test_ends_are_not_held_back_for_beginnings_and_the_last_is_always_written(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with logging(Form.JSON) as log:
        for number in range(BURST + 3):
            log.info("input_lost", begins=True, number=number)
            log.info("input_lost", begins=False, number=number)
    lines = said(capsys)
    assert [line["number"] for line in lines if line["begins"]] == [*range(BURST)]
    assert [line["number"] for line in lines if not line["begins"]] == [*range(BURST), BURST + 2]
    assert lines[-1]["suppressed"] == 2 * 3 - 1


def test_a_line_that_was_held_back_is_written_later_with_the_time_of_what_it_tells(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_module, "PER_SECOND", 0.5)
    monkeypatch.setattr(log_module, "LATE_S", 0.05)
    with logging(Form.JSON) as log:
        for number in range(BURST + 3):
            log.info("state", number=number)
        lines, until = said(capsys), time.monotonic() + 30
        while BURST + 2 not in [line["number"] for line in lines]:
            assert time.monotonic() < until
            time.sleep(0.05)
            lines += said(capsys)
        assert len(lines) == BURST + 1
        first, last = (datetime.fromisoformat(str(line["time"])) for line in (lines[0], lines[-1]))
        assert (last - first).total_seconds() < 1
        assert lines[-1]["suppressed"] == 2
    assert said(capsys) == []


@pytest.mark.parametrize("event", ["configuration", "command", "snapshot"])
def test_answers_to_an_operators_own_acts_are_not_held_back(
    capsys: pytest.CaptureFixture[str], event: str
) -> None:
    with logging(Form.JSON) as log:
        for number in range(50):
            log.info(event, begins=True, number=number)
    assert [line["number"] for line in said(capsys)] == [*range(50)]
