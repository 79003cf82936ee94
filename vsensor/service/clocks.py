"""Whether the two channels are told by one clock."""

from vsensor.config import Rig
from vsensor.grid import NS

LOOKS = 3
"""So often in a row, once a second, the two are as far apart: a backlog is made up for, a clock stays."""


class Clocks:
    """The times of both channels' newest samples, as they are seen once a second."""

    def __init__(self, rig: Rig) -> None:
        self._most_ns = round(rig.measurement.max_gap * NS)
        self._before: tuple[int, int] | None = None
        self._looks = 0

    def apart(self, torque_ns: int | None, speed_ns: int | None) -> str:
        """How far they are apart, in words: none where they are not, or where a channel is silent."""
        before, self._before = self._before, None
        if torque_ns is None or speed_ns is None:
            self._looks = 0
            return ""
        self._before = (torque_ns, speed_ns)
        ahead_ns = speed_ns - torque_ns
        self._looks = self._looks + 1 if before and self._as_before(ahead_ns, before) else 0
        if self._looks < LOOKS:
            return ""
        where = "ahead of" if ahead_ns > 0 else "behind"
        return f"speed's is {abs(ahead_ns) / NS:.1f} s {where} torque's"

    def _as_before(self, ahead_ns: int, before: tuple[int, int]) -> bool:
        torque_ns, speed_ns = before
        both_speak = self._before is not None and self._before[0] > torque_ns and self._before[1] > speed_ns
        steady = abs(ahead_ns - (speed_ns - torque_ns)) < self._most_ns
        return both_speak and steady and abs(ahead_ns) > self._most_ns
