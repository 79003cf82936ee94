"""The view in a window of its own, as it stands on a screen: a recorded session, and a live demonstration."""

import time
from pathlib import Path

import pytest

from tests.pixels import shows_curves
from tests.view_process import at_work, free_port
from tests.x_screen import MISSING, screen

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(bool(MISSING), reason=MISSING),
    pytest.mark.timeout(300),
]

SESSION = Path("recordings/stick_slip.mcap").resolve()
PATIENCE_S = 200.0
"""Without a graphics card a frame takes a while, and longer on a machine that is busy."""
LOOK_S = 0.5


def shows_its_curves(*command: str, folder: Path) -> bool:
    """Whether the window of a command of ours comes to show curves; what was seen last is left in a file."""
    with (
        screen(folder, 1200, 800) as seen,
        at_work(*command, cwd=folder, environment=seen.environment) as await_words,
    ):
        await_words("opens in a window of its own")
        end = time.monotonic() + PATIENCE_S
        while not (shown := shows_curves(seen.picture())) and time.monotonic() < end:
            time.sleep(LOOK_S)
        seen.keep(folder / "seen.png")
    return shown


def test_a_window_shows_a_recorded_session(tmp_path: Path) -> None:
    session = ("view", "--session", str(SESSION), "--data-port", str(free_port()))
    assert shows_its_curves(*session, folder=tmp_path), f"look at {tmp_path}/seen.png"


def test_a_window_shows_a_live_demonstration(tmp_path: Path) -> None:
    assert shows_its_curves("demo", folder=tmp_path), f"look at {tmp_path}/seen.png"
