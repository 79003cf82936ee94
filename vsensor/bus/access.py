"""Zenoh's settings for our part: from which file, as which user, and never a secret in our words."""

import json
import os
import re
import stat
from pathlib import Path
from typing import Literal

import zenoh

from vsensor.config import Bus
from vsensor.errors import ConfigError

Role = Literal["daemon", "client"]

PASSWORD = "VSENSOR_PASSWORD"  # noqa: S105 -- the name of a variable
SETTINGS = "ZENOH_CONFIG"  # Zenoh's own name for it

_QUEUE = "transport/link/tx/queue"
_AT_ONCE = {f"{_QUEUE}/size/data": 16, f"{_QUEUE}/congestion_control/drop/wait_before_drop": 0}
"""So many messages are held for a client that takes them slowly, Zenoh's most. By default it is two: the loop
then waited at most of a turn's messages until Zenoh's thread, or a busy machine, had sent the one before.
Where there are more the next is dropped at once: by default the loop waits a millisecond for room first, and
as many are dropped all the same."""

_STUMBLED = re.compile(r'msg: "(?P<what>.*)", location: .*line: (?P<line>\d+), column: (?P<column>\d+)')
_LOGIN = "transport/auth/usrpwd"
_TLS = "transport/link/tls"
_SECRET_FILES = (
    f"{_LOGIN}/dictionary_file",
    f"{_TLS}/listen_private_key",
    f"{_TLS}/connect_private_key",
)


def zenoh_config(bus: Bus, role: Role) -> zenoh.Config:
    """Zenoh's settings: the file's, under ours. The daemon listens and routes; a client connects to it.

    Raises ConfigError where the file or a secret cannot be used; its text holds neither of them.
    """
    file = _file(bus, role)
    config = zenoh.Config() if file is None else _from_file(*file)
    settings: dict[str, object] = {
        "mode": "router" if role == "daemon" else "client",
        "listen/endpoints": list(bus.listen) if role == "daemon" else [],
        "connect/endpoints": list(bus.connect) if role == "daemon" else list(bus.connect or bus.listen),
        "scouting/multicast/enabled": bus.multicast_scouting,
        "timestamping/enabled": True,
        # Nothing we send is large enough for it, and it wants locked memory, which containers seldom grant.
        "transport/shared_memory/enabled": False,
    }
    if role == "daemon":
        settings |= _AT_ONCE
    if bus.user is not None:
        settings |= {f"{_LOGIN}/user": bus.user, f"{_LOGIN}/password": _password(bus)}
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


def is_locked(config: zenoh.Config) -> bool:
    """Whether who connects must prove something: for a hint where the other end refuses."""
    tls, login = (json.loads(config.get_json(key)) for key in (_TLS, _LOGIN))
    return tls["root_ca_certificate"] is not None or login["user"] is not None


def without_place(error: zenoh.ZError) -> str:
    """Zenoh's message without the line of its own source."""
    return str(error).split(" at /")[0]


def _file(bus: Bus, role: Role) -> tuple[Path, str] | None:
    """The file of Zenoh's settings, and who named it."""
    if role == "client":
        if named := os.environ.get(SETTINGS):
            return Path(named), SETTINGS
        if bus.client_zenoh_config is not None:
            return bus.client_zenoh_config, "bus.client_zenoh_config"
    return None if bus.zenoh_config is None else (bus.zenoh_config, "bus.zenoh_config")


def _from_file(path: Path, named_by: str) -> zenoh.Config:
    try:
        config = zenoh.Config.from_file(path)
    except zenoh.ZError as error:
        why = _without_content(without_place(error))
        raise ConfigError(f"{named_by} {path}: is no Zenoh configuration (JSON5): {why}") from None
    if json.loads(config.get_json(f"{_LOGIN}/password")) is not None:
        _keep(path)
    for key in _SECRET_FILES:
        if (secret := json.loads(config.get_json(key))) is not None:
            _keep(Path(secret))
    return config


def _without_content(text: str) -> str:
    """Zenoh quotes what it stumbled over, which may be a password: its place and kind alone are told."""
    if found := _STUMBLED.search(text):
        text = f"line {found['line']}, column {found['column']}: {found['what']}".replace('\\"', '"')
    lines = (line.strip() for line in text.splitlines() if "|" not in line)
    return re.sub(r'"[^"]*"', '"…"', " ".join(line for line in lines if line))


def _keep(path: Path) -> None:
    """Refuse a secret that everyone on this machine can read."""
    try:
        mode = path.stat().st_mode
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    if mode & stat.S_IROTH:
        raise ConfigError(
            f"{path}: holds a secret that everyone on this machine can read: chmod o-rwx {path}"
        )


def _password(bus: Bus) -> str:
    if (given := os.environ.get(PASSWORD)) is not None:
        return given
    if bus.password_file is None:
        raise ConfigError(
            f"bus.user {bus.user}: has no password: name its file, password_file, or set {PASSWORD}"
        )
    _keep(bus.password_file)
    try:
        return bus.password_file.read_text(encoding="utf-8").removesuffix("\n")
    except (OSError, UnicodeDecodeError):
        raise ConfigError(
            f"bus.password_file {bus.password_file}: cannot be read as a line of text"
        ) from None
