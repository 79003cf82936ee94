"""A screen that nobody sees, with Vulkan in software: Xvfb and Mesa's lavapipe."""

import os
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from PIL import Image, ImageGrab

from tests.pixels import Pixels

_SERVER = shutil.which("Xvfb")
_DRIVER = next(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"), None)
MISSING = "" if _SERVER and _DRIVER else "no screen to draw on: apt-get install xvfb mesa-vulkan-drivers"


class Screen:
    """A screen on which a program draws that has its `environment`."""

    def __init__(self, display: str, folder: Path) -> None:
        self._display = display
        self.environment: Mapping[str, str] = {
            "DISPLAY": display,
            "WAYLAND_DISPLAY": "",
            "WGPU_BACKEND": "vulkan",
            "VK_ICD_FILENAMES": str(_DRIVER),
            "XDG_RUNTIME_DIR": str(folder),
        }

    def picture(self) -> Pixels:
        """What it looks like now, shape (height, width, 3)."""
        return np.asarray(ImageGrab.grab(xdisplay=self._display).convert("RGB"))

    def keep(self, file: Path) -> None:
        """Leave what it looks like in a file, to be looked at."""
        Image.fromarray(self.picture()).save(file)


@contextmanager
def screen(folder: Path, width: int, height: int) -> Iterator[Screen]:
    """A screen of so many pixels; it ends with the `with`."""
    numbers, number = os.pipe()
    # Without compositing no window is transparent: such a one, of 32 bits a pixel, Mesa's software puts on no
    # X screen, and it stays black.
    with subprocess.Popen(
        [
            str(_SERVER),
            *("-displayfd", str(number)),
            *("-screen", "0", f"{width}x{height}x24"),
            *("-nolisten", "tcp"),
            *("-extension", "Composite"),
        ],
        pass_fds=(number,),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as server:
        os.close(number)
        try:
            with os.fdopen(numbers) as told:
                display = told.readline().strip()
            assert display, "Xvfb did not start"
            yield Screen(f":{display}", folder)
        finally:
            server.terminate()
