"""Zenoh sessions that stay on this machine unless told otherwise."""

import os
import time

import zenoh

from vsensor.bus.access import Role, is_locked, without_place, zenoh_config
from vsensor.config import Bus
from vsensor.errors import BusError
from vsensor.messages import (
    SENSOR_ALIVE,
)

THREADS = "(acc: (handover: rx))"
"""Of Zenoh's threads those that decode what comes also wait for it. By default those that accept a link do,
and wake the others for each packet: at 2 kHz that took the daemon a tenth of what it takes of a processor."""


def open_session(bus: Bus, role: Role) -> zenoh.Session:
    """Open a session: the daemon listens and routes among its clients; a client connects to it.

    Use it in a `with`: a session left open keeps the process from ending. Raises BusError, and
    ConfigError where the file of Zenoh's own settings, or a secret, cannot be used.
    """
    config = zenoh_config(bus, role)
    # Read once in a process, at its first session. What an operator has set there goes before.
    os.environ.setdefault("ZENOH_RUNTIME", THREADS)
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        ends = ", ".join(bus.listen if role == "daemon" else bus.connect or bus.listen)
        raise BusError(f"no bus at {ends}: {_hint(config, role)} ({without_place(error)})") from error


def _hint(config: zenoh.Config, role: Role) -> str:
    if role == "daemon":
        return "is the port taken? Is this an address of this machine?"
    proof = " Does it take our certificate, our user and password?" if is_locked(config) else ""
    return f"is the daemon (vsensor run) up? Is this its address?{proof}"


def wait_for_sensor(session: zenoh.Session, prefix: str, timeout_s: float = 10.0) -> bool:
    """Wait until a daemon says that it listens below this prefix; False when none does in time."""
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        for reply in session.liveliness().get(f"{prefix}/{SENSOR_ALIVE}", timeout=1.0):
            if reply.ok is not None:
                return True
        time.sleep(0.1)
    return False
