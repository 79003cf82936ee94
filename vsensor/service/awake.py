"""Processors kept from their idle states, out of which they would take a while to wake: Linux's PM QoS.

The kernel heeds a request for as long as its descriptor is open, and then of itself no longer.
"""

import os
from pathlib import Path

DEVICE = Path("/dev/cpu_dma_latency")
DRIVER = Path("/sys/devices/system/cpu/cpuidle/current_driver")
_AT_ONCE = (0).to_bytes(4, "little")
"""How long a processor may take to wake, a 32-bit number of µs: a zero looks the same either way round."""


class WakeRequest:
    """A request, in the name of the whole process, that processors which wait be there at once."""

    def __init__(self) -> None:
        self._descriptor: int | None = None

    @property
    def stands(self) -> bool:
        """Whether it is made, and not withdrawn."""
        return self._descriptor is not None

    def make(self) -> str:
        """Make it; returns "", or why it is refused, with what would help."""
        self.withdraw()
        try:
            # Closed in whatever is started: a recorder that outlives the daemon must not go on asking.
            self._descriptor = os.open(DEVICE, os.O_WRONLY | os.O_CLOEXEC)
            os.write(self._descriptor, _AT_ONCE)
        except OSError as error:
            self.withdraw()
            return f"stay awake: {DEVICE}: {error.strerror}: {_what_helps(error)}"
        if _nobody_heeds():
            self.withdraw()
            return f"stay awake: {DRIVER}: none: nobody here would heed it (x86: boot with idle=poll instead)"
        return ""

    def withdraw(self) -> None:
        """Let the processors idle as they would, unless somebody else asks."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None


def _what_helps(error: OSError) -> str:
    if isinstance(error, FileNotFoundError):
        return "the kernel has none (CONFIG_CPU_IDLE), or a container or systemd's PrivateDevices= hides it"
    return "needs leave to write to it: root's, or by a rule of udev; in a container its device cgroup's too"


def _nobody_heeds() -> bool:
    """Whether the kernel has no driver of idle states: then a processor halts, whatever is asked."""
    try:
        return DRIVER.read_text(encoding="ascii").strip() == "none"
    except OSError:
        return False  # it does not say
