"""So many a second and no more: what keeps a flood from the loop."""

from vsensor.grid import NS


class Allowance:
    """A bucket of tokens that fills with time; each thing let through takes one.

    Of any time span, `per_second` times its length and `burst` more are let through, never more.
    """

    def __init__(self, per_second: float, burst: int) -> None:
        self._period_ns = int(NS / per_second)
        self._burst_ns = burst * self._period_ns
        self._full_ns = 0
        """When the bucket is full again."""

    def take(self, now_ns: int) -> bool:
        """Whether one more is let through now, by a monotonic clock."""
        full_ns = max(self._full_ns, now_ns) + self._period_ns
        if full_ns - now_ns > self._burst_ns:
            return False
        self._full_ns = full_ns
        return True
