"""What made a session: versions and machine, for its metadata."""

import os
import platform
from importlib.metadata import version

from vsensor.config import Rig

PACKAGES = ("vsensor", "numpy", "numba", "llvmlite", "eclipse-zenoh", "mcap", "protobuf")


def provenance(rig: Rig) -> dict[str, str]:
    """Rig, rate, versions and machine as text, for a session's metadata."""
    return {
        "rig": rig.rig.name,
        "rate_hz": f"{rig.loop.rate:g}",
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.release()}",
        "machine": platform.machine(),
        "processors": str(os.cpu_count()),
        **{name: version(name) for name in PACKAGES},
    }
