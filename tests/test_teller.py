"""What the log says of each second: the states in which nothing is amiss are no warnings."""

from collections.abc import Mapping
from typing import cast

import pytest
import structlog
from structlog.testing import capture_logs

from vsensor.cli.teller import Teller
from vsensor.messages import Status
from vsensor.messages.states import INPUT_LOST, STARTING, STATES
from vsensor.recording.recorder import Recorder


class Untroubled:
    """A recorder that records."""

    def trouble(self) -> str:
        return ""


@pytest.mark.parametrize("state", STATES)
def test_a_state_is_a_warning_only_where_something_is_amiss(state: str) -> None:
    said = told(Status(state=state))
    level = "warning" if state in (STARTING, INPUT_LOST) else "info"
    assert said == [{"event": "state", "state": state, "log_level": level}]


def told(status: Status) -> list[Mapping[str, object]]:
    with capture_logs() as lines:
        Teller(structlog.get_logger(), cast("Recorder", Untroubled())).tell(status, "", [])
    return list(lines)
