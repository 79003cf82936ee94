"""Chromium without a screen, spoken to over a pipe (Chrome DevTools Protocol)."""

import base64
import io
import json
import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from tests.pixels import Pixels

PROGRAM = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), ""
)
MISSING = "no browser here: apt-get install chromium"
_SWITCHES = (
    "--headless=new",
    "--no-sandbox",  # it is refused to root, and the page is our own
    "--disable-dev-shm-usage",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--mute-audio",
    "--no-first-run",
    "--disable-extensions",
    "--disable-background-networking",
    "--remote-debugging-pipe",
)


class Browser:
    """One page in a running browser."""

    def __init__(self, to_browser: int, from_browser: int) -> None:
        self._to = to_browser
        self._from = from_browser
        self._buffer = b""
        self._number = 0
        self._session = ""

    def open(self, url: str) -> None:
        """Open a page."""
        target = self._ask("Target.createTarget", url=url)["targetId"]
        self._session = self._ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]

    def picture(self) -> Pixels:
        """What the page looks like now, shape (height, width, 3)."""
        png = base64.b64decode(self._ask("Page.captureScreenshot", format="png")["data"])
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))

    def picture_when(self, ready: Callable[[Pixels], bool], patience_s: float) -> Pixels:
        """The first picture that is as wanted, or the last one before patience ends."""
        deadline = time.monotonic() + patience_s
        while not ready(picture := self.picture()) and time.monotonic() < deadline:
            time.sleep(2.0)  # a picture costs a frame, which the page needs to take in data
        return picture

    def _ask(self, method: str, **parameters: object) -> dict[str, Any]:
        self._number += 1
        order: dict[str, object] = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            order["sessionId"] = self._session
        os.write(self._to, json.dumps(order).encode() + b"\0")
        while True:
            answer = json.loads(self._next())
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return dict(answer["result"])

    def _next(self) -> bytes:
        while b"\0" not in self._buffer:
            came = os.read(self._from, 1 << 20)
            assert came, "the browser has ended"
            self._buffer += came
        message, _, self._buffer = self._buffer.partition(b"\0")
        return message


@contextmanager
def browser(folder: Path, width: int = 1280, height: int = 800) -> Iterator[Browser]:
    """A browser with its settings in `folder`; it ends with the `with`."""
    child_in, to_browser = os.pipe()
    from_browser, child_out = os.pipe()
    # The protocol wants the pipes as the file descriptors 3 and 4.
    wrapped = ["bash", "-c", f'exec "$@" 3<&{child_in} 4>&{child_out}', "bash", PROGRAM]
    with subprocess.Popen(
        [*wrapped, *_SWITCHES, f"--user-data-dir={folder}", f"--window-size={width},{height}", "about:blank"],
        pass_fds=(child_in, child_out),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:
        os.close(child_in)
        os.close(child_out)
        try:
            yield Browser(to_browser, from_browser)
        finally:
            os.close(to_browser)  # which ends it
            process.kill()
            os.close(from_browser)
