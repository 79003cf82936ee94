"""What systemd is told: that we are ready, alive, stopping. Nothing where it did not start us.

The protocol is a datagram of lines to the socket that NOTIFY_SOCKET names: sd_notify(3).
"""

import contextlib
import os
import socket

from vsensor.messages import Status


class Supervisor:
    """The service manager that started us, if one did."""

    def __init__(self) -> None:
        address = os.environ.get("NOTIFY_SOCKET", "")
        self._address = f"\0{address[1:]}" if address.startswith("@") else address
        self._before = Status()

    def ready(self) -> None:
        """The loop begins to turn."""
        self._send("READY=1")

    def stopping(self) -> None:
        """The loop has ended; the session is being completed."""
        self._send("STOPPING=1")

    def each_second(self, status: Status) -> None:
        """Feed the watchdog, unless ticks stand still although both channels speak.

        Where the loop does not turn this is not called at all; a rig that is silent is no fault of ours.
        """
        before, self._before = self._before, status
        spoke = _accepted(status) > _accepted(before) > 0 and status.ticks
        stuck = spoke and status.ticks == before.ticks
        self._send(f"STATUS={status.state}" + ("" if stuck else "\nWATCHDOG=1"))

    def _send(self, state: str) -> None:
        if not self._address:
            return
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as out:
            out.setblocking(False)  # the loop waits for nobody, not even for systemd
            out.sendto(state.encode(), self._address)


def _accepted(status: Status) -> int:
    """What the slower channel has given."""
    return min((channel.accepted for channel in status.channels), default=0)
