"""The web view as a real browser shows it: a live demonstration, and a recorded session."""

import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.browser import MISSING, PROGRAM, Pixels, browser
from tests.view_process import free_port, gone, offspring, reachable, until
from vsensor.view.batches import Colour
from vsensor.view.palette import BLUE, GREY, ORANGE, PINK

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(not PROGRAM, reason=MISSING),
    pytest.mark.timeout(300),
]

SESSION = Path("recordings/stick_slip.mcap").resolve()
PATIENCE_S = 200.0
"""Without a graphics card a frame takes a second, and ten on a machine that is busy."""
LEAST_PIXELS = 25
"""A curve of some width has many more."""


def pixels_of(picture: Pixels, colour: Colour) -> int:
    """How many pixels are of a colour, as near as smoothing leaves them."""
    return int((np.abs(picture.astype(int) - colour[:3]).max(axis=2) <= 8).sum())


def shows_curves(picture: Pixels) -> bool:
    """Whether bit (confirmed, now, foretold) and surface are drawn, below the large figures."""
    plots = picture[picture.shape[0] // 5 :, : picture.shape[1] * 7 // 10]
    return all(pixels_of(plots, colour) >= LEAST_PIXELS for colour in (BLUE, ORANGE, PINK, GREY))


@contextmanager
def served(*command: str, cwd: Path) -> Iterator[Callable[[], str]]:
    """A command of ours at work; yields what waits for the address of its page."""
    process = subprocess.Popen(
        [sys.executable, "-m", "vsensor.cli.main", *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=cwd,
        env=os.environ | {"DISPLAY": "", "WAYLAND_DISPLAY": ""},
    )
    said: list[str] = []
    assert process.stdout is not None
    listener = threading.Thread(target=said.extend, args=(process.stdout,))
    listener.start()

    def url() -> str:
        until(lambda: "open http" in "".join(said) or process.poll() is not None)
        found = re.search(r"open (\S+)", "".join(said))
        assert found, "".join(said)
        until(lambda: reachable(found[1]))
        return f"{found[1]}&renderer=webgl"

    try:
        yield url
        children = offspring(process.pid)
        process.send_signal(signal.SIGTERM)
        assert process.wait(30) == 0, "".join(said)
        assert all(gone(child) for child in children)
    finally:
        process.kill()
        process.wait()
        listener.join()
        process.stdout.close()


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
