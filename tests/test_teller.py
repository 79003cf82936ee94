"""What the log says of each second: what is amiss is a warning, what was refused too, all else is not."""

from collections.abc import Callable, Mapping

import pytest
import structlog
from structlog.testing import capture_logs

from vsensor.cli.teller import Teller, Trouble
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, ChannelStatus, Event, Status
from vsensor.messages.states import INPUT_LOST, STARTING, STATES


@pytest.mark.parametrize("state", STATES)
def test_a_state_is_a_warning_only_where_something_is_amiss(state: str) -> None:
    said = told(lambda teller: teller.tell(Status(state=state), {}, []))
    level = "warning" if state in (STARTING, INPUT_LOST) else "info"
    assert said == [{"event": "state", "state": state, "log_level": level}]


@pytest.mark.parametrize("name", ["configuration", "learned", "snapshot", "stuck"])
def test_what_was_refused_is_a_warning(name: str) -> None:
    events = [Event(name=name, begins=begins) for begins in (True, False)]
    said = told(lambda teller: teller.tell(Status(), {}, events))
    assert [line["log_level"] for line in said] == ["info", "info" if name == "stuck" else "warning"]


def test_each_channel_has_its_own_last_fault() -> None:
    torque, speed = (ChannelStatus(channel=topic, unreadable=1) for topic in (SURFACE_TORQUE, SURFACE_SPEED))
    faults = {SURFACE_TORQUE: "a sample is no JSON", SURFACE_SPEED: "a sample has no value"}
    said = told(lambda teller: teller.tell(Status(channels=[torque, speed]), faults, []))
    assert {line["event"]: line["last"] for line in said} == {
        "surface/torque unreadable": "a sample is no JSON",
        "surface/speed unreadable": "a sample has no value",
    }


def test_what_the_bus_has_lost_is_a_warning() -> None:
    (line,) = told(lambda teller: teller.tell(Status(bus_missed=7), {}, []))
    assert line == {"event": "missed on the bus", "more": 7, "total": 7, "log_level": "warning"}


def test_a_trouble_is_told_when_it_begins_when_it_changes_and_when_it_is_over() -> None:
    why = iter(("", "no disk", "no disk", "no folder", "", ""))
    trouble = Trouble("not saved", "saved again", lambda: next(why))

    def six_seconds(teller: Teller) -> None:
        for _ in range(6):
            teller.tell(Status(), {}, [])

    assert told(six_seconds, trouble) == [
        {"event": "not saved", "why": "no disk", "log_level": "error"},
        {"event": "not saved", "why": "no folder", "log_level": "error"},
        {"event": "saved again", "log_level": "info"},
    ]


def told(hear: Callable[[Teller], object], *troubles: Trouble) -> list[Mapping[str, object]]:
    with capture_logs() as lines:
        hear(Teller(structlog.get_logger(), troubles))
    return list(lines)
