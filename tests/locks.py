"""The examples of config/zenoh in a folder of their own, with an authority made by its script."""

import subprocess
from contextlib import ExitStack
from pathlib import Path
from typing import Self

import zenoh

from tests.daemons import free_bus
from vsensor.bus import open_session
from vsensor.config import Bus

EXAMPLES = Path(__file__).parent.parent / "config" / "zenoh"
USERS = {"surface": "drill-pipe", "viewer": "look/only", "driller": "brake"}


def make_authority(folder: Path, *hosts: str) -> None:
    """Run the script as a user would."""
    subprocess.run([EXAMPLES / "make-authority.sh", folder, *hosts], check=True, capture_output=True)


class Etc:
    """What lies in /etc/vsensor on a rig."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        make_authority(folder / "tls")
        (folder / "zenoh").mkdir()
        for file in EXAMPLES.glob("*.json5"):
            text = file.read_text(encoding="utf-8").replace("/etc/vsensor", str(folder))
            (folder / "zenoh" / file.name).write_text(text, encoding="utf-8")
        self.secret("users.txt", "".join(f"{user}:{word}\n" for user, word in USERS.items()))
        for user, word in USERS.items():
            self.secret(f"{user}.password", f"{word}\n")

    def secret(self, name: str, text: str) -> Path:
        """Write a file that others cannot read."""
        file = self.folder / name
        file.touch(mode=0o600)
        file.write_text(text, encoding="utf-8")
        return file

    def zenoh(self, name: str) -> Path:
        """One of the examples."""
        return self.folder / "zenoh" / f"{name}.json5"

    def bus(self, daemon: str) -> Bus:
        """A daemon behind this lock, on a free port."""
        (tcp,) = free_bus().listen
        return Bus(listen=(tcp.replace("tcp/", "tls/"),), zenoh_config=self.zenoh(daemon))

    def certified(self, bus: Bus, role: str) -> Bus:
        """The same bus for who shows this role's certificate."""
        return bus.model_copy(update={"client_zenoh_config": self.zenoh(role)})

    def logged_in(self, bus: Bus, user: str | None) -> Bus:
        """The same bus for who has this user's password."""
        file = self.folder / f"{user}.password" if user else None
        seen = {"client_zenoh_config": self.zenoh("client-tls"), "user": user, "password_file": file}
        return bus.model_copy(update=seen)


class Party:
    """A daemon and clients of several roles, each a real session over the lock."""

    def __init__(self, daemon: Bus, roles: dict[str, Bus]) -> None:
        self._stack = ExitStack()
        self.daemon = self._stack.enter_context(open_session(daemon, "daemon"))
        self.clients: dict[str, zenoh.Session] = {}
        for role, bus in roles.items():
            self.clients[role] = self._stack.enter_context(open_session(bus, "client"))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._stack.close()
