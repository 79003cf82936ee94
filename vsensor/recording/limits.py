"""How long sessions are, how long they are kept, and what room is left on their disk."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Limits:
    """Times in s, sizes in bytes; 0 is no limit."""

    split_every: float = 0.0
    split_size: float = 0.0
    keep_for: float = 0.0
    """Complete sessions of this rig that are older are deleted;"""
    keep_size: float = 0.0
    """and the oldest, while all of them together are larger."""
    keep_free: float = 0.0
    """With less room than this on the disk nothing is written."""
    memory: float = 0.0
    """So much of the newest is held in memory, for a snapshot."""


NO_LIMITS = Limits()
