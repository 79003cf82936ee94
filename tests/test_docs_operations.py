"""The operations page knows every word that the sensor says."""

import re
from pathlib import Path

import pytest

from vsensor.messages.books import REFUSALS
from vsensor.messages.states import STATES
from vsensor.quality import Quality, Reason, verdict

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "operations.md").read_text(encoding="utf-8")
TOLD = re.compile(r'(?:Condition\(\s*|\bname=|_tell\(|note\()"([a-z_]+)"')


def rows(cells: int) -> list[list[str]]:
    found = (line.strip("| \n").split(" | ") for line in PAGE.splitlines() if line.startswith("| "))
    return [row for row in found if len(row) == cells]


def events() -> set[str]:
    rooms = ("service", "recording")
    files = (path for room in rooms for path in (ROOT / "vsensor" / room).glob("*.py"))
    told = {name for path in files for name in TOLD.findall(path.read_text(encoding="utf-8"))}
    return told - {"keeper", "reload"}  # threads' names


@pytest.mark.parametrize("reason", list(Reason))
def test_each_flag_is_explained_with_the_quality_that_it_makes(reason: Reason) -> None:
    (quality,) = (row[1] for row in rows(4) if row[0] == reason.words())
    assert quality == Quality(verdict(reason)).name.lower()


def test_each_event_is_explained() -> None:
    explained = {name for row in rows(3) for name in re.findall(r"`([a-z_]+)`", row[0])}
    assert len(events()) > 10
    assert events() <= explained


def test_each_refusal_state_and_alert_is_explained() -> None:
    first = {row[0] for row in rows(3)} | {row[0] for row in rows(2)}
    alerts = (ROOT / "config" / "prometheus" / "alerts.yml").read_text(encoding="utf-8")
    wanted = {reason.replace("_", " ") for reason in REFUSALS} | set(STATES)
    wanted |= set(re.findall(r"alert: (\w+)", alerts))
    assert wanted <= first
