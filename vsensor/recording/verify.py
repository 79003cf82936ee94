"""Recorded inputs run again: every estimate must come out as it was recorded, bit for bit."""

import struct
from collections.abc import Callable
from dataclasses import dataclass

from vsensor.messages import BIT_ESTIMATE, SENSOR_TICK, Estimate, Tick
from vsensor.recording.reader import Session


@dataclass(frozen=True, slots=True)
class Mismatch:
    """Where the two first differ: the tick's number, the field, what was recorded and what came out now."""

    number: int
    field: str
    recorded: object
    recomputed: object


@dataclass(frozen=True, slots=True)
class Gap:
    """Ticks that the recorder did not get: the estimator's state after them cannot be had again."""

    expected: int
    found: int


@dataclass(frozen=True, slots=True)
class Verdict:
    """What verification found; `compared` are the ticks whose estimate was recorded too."""

    ticks: int
    compared: int
    mismatches: int
    first: Mismatch | None
    gap: Gap | None

    @property
    def exact(self) -> bool:
        """Whether something was compared, nothing differed and nothing was missing."""
        return self.compared > 0 and not self.mismatches and self.gap is None


def verify(session: Session, step: Callable[[Tick], Estimate]) -> Verdict:
    """Feed the session's ticks to `step` in order and compare its estimates with the recorded ones.

    A tick numbered 0 is an estimator's first: `step` has forgotten all input there. A tick's estimate stands
    behind it in the file. At a hole in the numbers verification ends, with `gap` telling where.
    """
    ticks = compared = mismatches = 0
    first: Mismatch | None = None
    recomputed: Estimate | None = None
    expected = 0
    for _, message, _, _ in session.messages((SENSOR_TICK, BIT_ESTIMATE)):
        if isinstance(message, Tick):
            if message.number not in (expected, 0):
                return Verdict(ticks, compared, mismatches, first, Gap(expected, message.number))
            recomputed = step(message)
            expected = message.number + 1
            ticks += 1
        elif isinstance(message, Estimate) and recomputed and _same_tick(message, recomputed):
            compared += 1
            if (found := _difference(message, recomputed)) is not None:
                mismatches += 1
                first = first or found
    return Verdict(ticks, compared, mismatches, first, None)


def _difference(recorded: Estimate, recomputed: Estimate) -> Mismatch | None:
    """Where two estimates first differ; None where every field is the same, floats bit for bit."""
    if recorded.SerializeToString() == recomputed.SerializeToString():
        return None
    for field in Estimate.DESCRIPTOR.fields:
        was, is_now = (_value(estimate, field.name) for estimate in (recorded, recomputed))
        if _bits(was) != _bits(is_now):
            return Mismatch(recorded.number, field.name, was, is_now)
    return None


def _same_tick(one: Estimate, other: Estimate) -> bool:
    return one.number == other.number and one.time_ns == other.time_ns


def _value(estimate: Estimate, name: str) -> float | None:
    return getattr(estimate, name) if estimate.HasField(name) else None  # type: ignore[arg-type]


def _bits(value: float | None) -> object:
    """What tells apart all that == does not: 0 and −0, one NaN and another, and makes NaN equal itself."""
    return struct.pack("<d", value) if isinstance(value, float) else value
