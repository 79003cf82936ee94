"""The web view as a real browser shows it: a live demonstration, and a recorded session."""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from PIL import Image

from tests.browser import MISSING, PROGRAM, browser
from tests.pixels import Pixels, shows_curves
from tests.view_process import at_work, free_port, reachable, until

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(not PROGRAM, reason=MISSING),
    pytest.mark.timeout(300),
]

SESSION = Path("recordings/stick_slip.mcap").resolve()
PATIENCE_S = 200.0
"""Without a graphics card a frame takes a second, and ten on a machine that is busy."""


@contextmanager
def served(*command: str, cwd: Path) -> Iterator[Callable[[], str]]:
    """A command of ours at work; yields what waits for the address of its page."""
    with at_work(*command, cwd=cwd) as await_words:

        def url() -> str:
            found = re.search(r"open (http\S+)", await_words("open http"))
            assert found
            until(lambda: reachable(found[1]))
            return f"{found[1]}&renderer=webgl"

        yield url


def looked_at(url: str, folder: Path) -> Pixels:
    """Open a page and wait until it shows curves; what was seen last is left in a file, to be looked at."""
    with browser(folder / "profile", 900, 600) as page:
        page.open(url)
        picture = page.picture_when(shows_curves, PATIENCE_S)
    Image.fromarray(picture).save(folder / "seen.png")
    return picture


def test_a_browser_shows_a_recorded_session(tmp_path: Path) -> None:
    ports = ["--port", str(free_port()), "--data-port", str(free_port())]
    with served("view", "--session", str(SESSION), "--web", *ports, cwd=tmp_path) as url:
        assert shows_curves(looked_at(url(), tmp_path)), f"look at {tmp_path}/seen.png"


def test_a_browser_shows_a_live_demonstration(tmp_path: Path) -> None:
    with served("demo", "--web", cwd=tmp_path) as url:
        assert shows_curves(looked_at(url(), tmp_path)), f"look at {tmp_path}/seen.png"
