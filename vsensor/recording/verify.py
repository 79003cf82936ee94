"""Recorded inputs run again: every estimate must come out as it was recorded, bit for bit."""

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from vsensor.errors import InputError
from vsensor.messages import BIT_ESTIMATE, SENSOR_STATE, SENSOR_TICK, Estimate, State, Tick
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
    """Ticks that the recorder did not get: the estimator is known again at the next recorded state.

    `expected` is None where a session begins in the middle without one.
    """

    expected: int | None
    found: int


class Machine(Protocol):
    """What runs a session's inputs again."""

    def step(self, tick: Tick) -> Estimate:
        """Run one tick; number 0 means that all input before is forgotten. ValueError where it cannot be."""

    def take_up(self, state: State) -> None:
        """Go on from a recorded state; ValueError where it does not fit."""

    def forget(self) -> None:
        """Forget all input; what was learned stays."""


@dataclass(slots=True)
class Verdict:
    """What verification found; `compared` are the ticks run again whose estimate was recorded too."""

    ticks: int = 0
    compared: int = 0
    skipped: int = 0
    """Ticks behind a gap, which could not be run again."""
    mismatches: int = 0
    first: Mismatch | None = None
    gaps: list[Gap] = field(default_factory=list)
    misfit: str = ""
    """Why the first of the recorded states that did not fit was not taken up."""

    @property
    def idle(self) -> bool:
        """Whether there was nothing to run: a part of a recording during which no samples came."""
        return not (self.ticks or self.skipped or self.misfit)

    @property
    def exact(self) -> bool:
        """Whether something was compared, nothing differed and nothing was missing."""
        return self.compared > 0 and not (self.mismatches or self.gaps or self.misfit)


Pair = tuple[Estimate, Estimate]
"""An estimate as it was recorded, and as it comes out now."""


def verify(
    session: Session, machine: Machine, *, strict: bool = True, see: Callable[[Pair], None] = lambda _: None
) -> Verdict:
    """Run the session's ticks again in order, and compare the estimates with the recorded ones.

    A session's first state, and the first behind a hole in the ticks' numbers, is taken up; so each part of a
    recording stands alone. A tick's estimate stands behind it in the file. `see` hears of each pair. Ticks
    whose past is not known are passed over; where not `strict`, they are run as after a long silence.
    Raises InputError for a tick that the machine refuses.
    """
    verdict = Verdict()
    run = _Run(machine, verdict, strict)
    for _, message, _, _ in session.messages((SENSOR_STATE, SENSOR_TICK, BIT_ESTIMATE)):
        if isinstance(message, State):
            run.state(message)
        elif isinstance(message, Tick):
            try:
                run.tick(message)
            except ValueError as error:
                name = f"{session.path}: tick {message.number}"
                raise InputError(f"{name} cannot be run again: {error}") from error
        elif isinstance(message, Estimate) and run.newest and _same_tick(message, run.newest):
            verdict.compared += 1
            see((message, run.newest))
            if (found := _difference(message, run.newest)) is not None:
                verdict.mismatches += 1
                verdict.first = verdict.first or found
    return verdict


class _Run:
    """The machine, and whether its memory is what the recording sensor's was."""

    def __init__(self, machine: Machine, verdict: Verdict, strict: bool) -> None:
        self.newest: Estimate | None = None
        self._machine = machine
        self._verdict = verdict
        self._strict = strict
        self._expected: int | None = None
        self._knows = False

    def state(self, state: State) -> None:
        if self._knows and state.number in (self._expected, 0):
            return
        try:
            self._machine.take_up(state)
        except ValueError as error:
            self._verdict.misfit = self._verdict.misfit or str(error)
        else:
            if self._knows:  # what was lost ends here, as no tick has told yet
                self._verdict.gaps.append(Gap(self._expected, state.number))
            self._knows = True
            self._expected = state.number

    def tick(self, tick: Tick) -> None:
        verdict = self._verdict
        first = verdict.ticks + verdict.skipped == 0
        # Number 0 begins anew, but with what was learned before: known to who saw it, or where nothing was.
        self._knows = (self._knows or first) and tick.number in (self._expected or 0, 0)
        if (first or tick.number != self._expected) and not self._knows and tick.number:
            verdict.gaps.append(Gap(self._expected, tick.number))
            self._machine.forget()
        self._expected = tick.number + 1
        if self._knows or not self._strict:
            self.newest = self._machine.step(tick)
            verdict.ticks += 1
        else:
            self.newest = None
            verdict.skipped += 1


def _difference(recorded: Estimate, recomputed: Estimate) -> Mismatch | None:
    """Where two estimates first differ; None where every field is the same, floats bit for bit."""
    if recorded.SerializeToString() == recomputed.SerializeToString():
        return None
    for described in Estimate.DESCRIPTOR.fields:
        name = described.name
        was, is_now = (_value(estimate, name) for estimate in (recorded, recomputed))
        if _bits(was) != _bits(is_now):
            return Mismatch(recorded.number, name, was, is_now)
    return None


def _same_tick(one: Estimate, other: Estimate) -> bool:
    return one.number == other.number and one.time_ns == other.time_ns


def _value(estimate: Estimate, name: str) -> float | None:
    return getattr(estimate, name) if estimate.HasField(name) else None  # type: ignore[arg-type]


def _bits(value: float | None) -> object:
    """What tells apart all that == does not: 0 and −0, one NaN and another, and makes NaN equal itself."""
    return struct.pack("<d", value) if isinstance(value, float) else value
