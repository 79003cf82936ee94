"""Rerun's viewer as a process of its own."""

import os
import shutil
import subprocess
from importlib import resources
from typing import Self

from vsensor.view.place import Place

# Rerun's program sends usage statistics to its makers; a rig's network is no place for that, and its
# switch for CI is the one that works without touching the user's settings.
ENVIRONMENT = {"RUST_LOG": "error", "CI": "1"}
_MEMORY_LIMIT = "2GB"
_GRACE_S = 2.0


class Viewer:
    """A viewer that draws from a server of ours: it may freeze or die without us, but it ends with us.

    In a session of its own, so that Ctrl-C in the terminal reaches only us, who then end it.
    """

    def __init__(self, place: Place) -> None:
        if place.kind == "window":
            what = ["--connect", place.source, "--memory-limit", _MEMORY_LIMIT, "--hide-welcome-screen"]
        else:
            what = [place.source, "--serve-web", "--web-viewer-port", str(place.page_port)]
        self._process = subprocess.Popen(
            [*ending_with(os.getpid()), program(), "--bind", place.bind, *what],
            env=os.environ | ENVIRONMENT,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        try:
            self._process.wait(_GRACE_S)
        except subprocess.TimeoutExpired:  # a frozen one heeds no signal but this
            self._process.kill()
            self._process.wait()

    def ended(self) -> int | None:
        """The exit status once it has ended; 0 where its window was closed."""
        return self._process.poll()


def program() -> str:
    """Rerun's binary: the script `rerun` about it would orphan it."""
    return str(resources.files("rerun_cli") / "rerun")


def ending_with(parent: int) -> list[str]:
    """What to put before a command so that Linux ends it where this parent of it is killed and cannot.

    By prctl(2), PR_SET_PDEATHSIG, which does nothing where the parent was killed before it: so we look again.
    """
    setpriv = shutil.which("setpriv")
    look = ["sh", "-c", 'test "$PPID" = "$0" && exec "$@"', str(parent)]
    return [setpriv, "--pdeathsig", "KILL", *look] if setpriv else []
