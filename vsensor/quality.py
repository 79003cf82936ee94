"""How far a number can be trusted, and why not further: the words that all rooms share."""

from enum import IntEnum, IntFlag


class Quality(IntEnum):
    """The verdict on a number, as OPC UA and the drilling data standards grade it."""

    GOOD = 1
    UNCERTAIN = 2
    BAD = 3


class Reason(IntFlag):
    """Why a number is not good; a set of flags, its values fixed by recorded sessions."""

    WARMING_UP = 1 << 0
    """The delay lines are not filled yet: the waves that make the answer have not all been seen."""
    GAP_BRIDGED = 1 << 1
    """Samples were missing; the gap was bridged by a straight line."""
    STALE_TORQUE = 1 << 2
    """The torque channel is silent: the string is run by speed alone under the load law."""
    STALE_SPEED = 1 << 3
    """The speed channel is silent: the string is run by torque alone under the load law."""
    SOURCE_UNCERTAIN = 1 << 4
    """The source itself called a sample less than good."""
    STRING_CHANGED = 1 << 5
    """The string was made longer or shorter: waves of before are still in it."""
    FROZEN_TORQUE = 1 << 6
    """Torque repeats one value, to the last digit and longer than it ever does, while the speed moves."""
    FROZEN_SPEED = 1 << 7
    """Speed does, while the torque moves."""
    IN_SLIPS = 1 << 8
    """The string stands as it would not under this torque: slips hold it, and what it is twisted by."""
    TORQUE_TOO_LOW = 1 << 9
    """The string turns under less torque than its wall takes, however wrong friction may be."""

    def words(self) -> str:
        """The flags in plain words, comma separated; empty for none."""
        return ", ".join(flag.name.lower().replace("_", " ") for flag in self if flag.name)


_WARMING_UP, _BOTH_STALE = int(Reason.WARMING_UP), int(Reason.STALE_TORQUE | Reason.STALE_SPEED)


def verdict(reasons: int) -> Quality:
    """Grade flags of `Reason`: bad where a number must not be used, uncertain where with care."""
    if reasons & _WARMING_UP or reasons & _BOTH_STALE == _BOTH_STALE:
        return Quality.BAD
    return Quality.UNCERTAIN if reasons else Quality.GOOD
