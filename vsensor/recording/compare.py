"""Two runs over the same inputs held against one another: what changed, where and by how much.

Answers are compared at the same moment of the well, not at the same tick: under another configuration
confirmed may be for another time. Memory does not grow with the session.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.messages import Estimate
from vsensor.recording.verify import Pair

Floats = NDArray[np.float64]

BLOCK = 20_000
"""Ticks compared at once."""
CARRIED = 2_000
"""Of those before, so many are kept: an answer for a moment may come so much later in the other run."""
COLUMNS = 1_500
"""A picture is no wider: in each column stand the least and the greatest of its ticks."""


class Quantity(NamedTuple):
    """One answer of an estimate."""

    kind: str
    """confirmed, now or forecast."""
    name: str
    time: str
    value: str
    std: str
    factor: float
    """From SI to the unit in which people read it."""
    unit: str


def _quantities() -> list[Quantity]:
    return [
        Quantity(
            kind, f"bit {what}", time, f"{kind}_bit_{what}_{si}", f"{kind}_bit_{what}_std_{si}", factor, unit
        )
        for what, si, factor, unit in (
            ("speed", "rad_s", 30 / math.pi, "rpm"),
            ("torque", "nm", 1e-3, "kN·m"),
        )
        for kind, time in (
            ("confirmed", "confirmed_time_ns"),
            ("now", "time_ns"),
            ("forecast", "forecast_time_ns"),
        )
    ]


QUANTITIES = _quantities()


@dataclass(slots=True)
class Envelope:
    """What a picture shows: per column time (s), and least and greatest of recorded, now and the change."""

    time_s: list[float] = field(default_factory=list)
    recorded: list[tuple[float, float]] = field(default_factory=list)
    now: list[tuple[float, float]] = field(default_factory=list)
    change: list[tuple[float, float]] = field(default_factory=list)


@dataclass(slots=True)
class Change:
    """How one quantity changed, in its people's unit; times in s from the session's first tick."""

    quantity: Quantity
    compared: int = 0
    squares: float = 0.0
    largest: float = 0.0
    largest_at_s: float = math.nan
    first_at_s: float = math.nan
    """NaN where nothing changed."""
    std_recorded: float = 0.0
    """Mean of the stated deviation; likewise"""
    std_now: float = 0.0
    envelope: Envelope = field(default_factory=Envelope)

    @property
    def rms(self) -> float:
        """Root mean square of the change."""
        return math.sqrt(self.squares / self.compared) if self.compared else math.nan


class _Run:
    """The answers of one run that the other has not reached yet: rows of time (ns), value, deviation."""

    def __init__(self) -> None:
        self.rows: list[tuple[int, float, float]] = []

    def add(self, quantity: Quantity, estimate: Estimate) -> None:
        if estimate.HasField(quantity.value):  # type: ignore[arg-type]
            time_ns, value, std = (
                getattr(estimate, name) for name in (quantity.time, quantity.value, quantity.std)
            )
            self.rows.append((time_ns, value, std))

    def sorted(self) -> tuple[NDArray[np.int64], Floats, Floats]:
        self.rows.sort()
        time_ns = np.array([row[0] for row in self.rows], np.int64)
        numbers = np.array([row[1:] for row in self.rows], np.float64).reshape(-1, 2)
        return time_ns, numbers[:, 0], numbers[:, 1]


class _Track:
    """One quantity through both runs."""

    def __init__(self, quantity: Quantity, per_column: int) -> None:
        self.change = Change(quantity)
        self._per_column = per_column
        self._recorded, self._now = _Run(), _Run()

    def add(self, pair: Pair, begun_ns: int) -> None:
        self._recorded.add(self.change.quantity, pair[0])
        self._now.add(self.change.quantity, pair[1])
        if max(len(self._recorded.rows), len(self._now.rows)) >= BLOCK + CARRIED:
            self.compare(begun_ns, last=False)

    def compare(self, begun_ns: int, *, last: bool) -> None:
        """Compare what both runs have answers for; at the `last` of a grid of ticks forget the rest."""
        time_ns, values, stds = self._recorded.sorted()
        now_ns, now_values, now_stds = self._now.sorted()
        if len(time_ns) and len(now_ns):
            within = (time_ns >= now_ns[0]) & (time_ns <= now_ns[-1])
            at = (time_ns[within] - begun_ns) / 1e9
            now_at = (now_ns - begun_ns) / 1e9
            factor = self.change.quantity.factor
            now = factor * np.interp(at, now_at, now_values)
            self._note(at, factor * values[within], now)
            self.change.std_recorded += factor * float(stds[within].sum())
            self.change.std_now += factor * float(np.interp(at, now_at, now_stds).sum())
            self._recorded.rows = self._recorded.rows[int(np.searchsorted(time_ns, now_ns[-1], "right")) :]
        # Where one of the runs has fallen silent, the other's answers do not wait for it for ever.
        self._recorded.rows = self._recorded.rows[-CARRIED:]
        self._now.rows = self._now.rows[-CARRIED:]
        if last:
            self._recorded.rows.clear()
            self._now.rows.clear()

    def _note(self, at: Floats, recorded: Floats, now: Floats) -> None:
        if not len(at):
            return
        change, difference = self.change, now - recorded
        change.compared += len(at)
        change.squares += float(difference @ difference)
        worst = int(np.argmax(np.abs(difference)))
        if abs(difference[worst]) > abs(change.largest):
            change.largest, change.largest_at_s = float(difference[worst]), float(at[worst])
        if math.isnan(change.first_at_s) and difference.any():
            change.first_at_s = float(at[np.flatnonzero(difference)[0]])
        starts = np.arange(0, len(at), self._per_column)
        change.envelope.time_s += at[starts].tolist()
        for into, numbers in (
            (change.envelope.recorded, recorded),
            (change.envelope.now, now),
            (change.envelope.change, difference),
        ):
            least, greatest = np.minimum.reduceat(numbers, starts), np.maximum.reduceat(numbers, starts)
            into += zip(least.tolist(), greatest.tolist(), strict=True)


class Comparison:
    """Hears of each pair of a verification; `changes` hold once it is finished."""

    def __init__(self, ticks: int) -> None:
        self.qualities = 0
        """Ticks whose quality is another."""
        self._tracks = [_Track(quantity, max(1, ticks // COLUMNS)) for quantity in QUANTITIES]
        self._begun_ns: int | None = None
        self._number = -1

    @property
    def changes(self) -> list[Change]:
        """One for each of QUANTITIES."""
        return [track.change for track in self._tracks]

    def see(self, pair: Pair) -> None:
        """Take an estimate as recorded and as it comes out now."""
        recorded, now = pair
        if self._begun_ns is None:
            self._begun_ns = recorded.time_ns
        if recorded.number <= self._number:  # the grid was laid anew: times may have jumped
            self.finish()
        self._number = recorded.number
        self.qualities += recorded.quality != now.quality
        for track in self._tracks:
            track.add(pair, self._begun_ns)

    def finish(self) -> None:
        """Compare what is still open."""
        for track in self._tracks:
            track.compare(self._begun_ns or 0, last=True)
