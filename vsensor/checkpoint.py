"""All that the sensor remembers between two ticks, as one message: taken up, it goes on to the same bits."""

import json
import math
import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vsensor.estimator.estimator import LENGTH, Estimator
from vsensor.intake import Intake
from vsensor.messages import Array, State

_NUMBERS = re.compile(r"[<>|=][biuf]\d{1,2}")
MOST_CHARACTERS = 1 << 24
"""Of what the intake remembers: read, they take thirty times the room. All samples of minutes take less."""
ROUNDING_M = 1e-3
Arrays = Sequence[NDArray[np.generic]]


def remembered(intake: Intake, estimator: Estimator) -> tuple[State, Arrays]:
    """What both remember: the message without its numbers, and those, array by array.

    Apart, so that a loop need not copy megabytes into a message: `whole` puts them together.
    """
    saved = estimator.save()
    held = intake.save()
    state = State(
        number=held["number"],
        intake=json.dumps(held),
        arrays=[Array(name=name, dtype=array.dtype.str, shape=array.shape) for name, array in saved.items()],
    )
    if held["consumed_ns"] is not None:
        state.time_ns = held["consumed_ns"]
    return state, list(saved.values())


def whole(state: State, arrays: Arrays) -> State:
    """The message with its numbers."""
    for described, array in zip(state.arrays, arrays, strict=True):
        described.data = array.tobytes()
    return state


def take_up(state: State, intake: Intake, estimator: Estimator) -> None:
    """Go on from a recorded state.

    Raises ValueError where it does not fit this configuration or version, and changes nothing.
    """
    try:
        saved = {described.name: array_of(described) for described in state.arrays}
        held = _read(state.intake)
    except ValueError as error:
        raise ValueError(f"the recorded state cannot be read: {error}") from error
    before = intake.save(), estimator.save()
    try:
        estimator.restore(saved)
        intake.restore(held)
        _refuse_two_lengths(intake, estimator)
    except ValueError:
        intake.restore(before[0])
        estimator.restore(before[1])
        raise


def _read(intake: str) -> object:
    if len(intake) > MOST_CHARACTERS:
        raise ValueError(f"what the intake remembers takes more than {MOST_CHARACTERS} characters")
    try:
        return json.loads(intake)
    except RecursionError:
        raise ValueError("what the intake remembers is a list within lists without end") from None


def _refuse_two_lengths(intake: Intake, estimator: Estimator) -> None:
    """Raise ValueError where the two do not agree how long the string was."""
    told, length = intake.depths.length_at_tick, sum(part.length for part in estimator.string)
    if not abs(length - told) <= ROUNDING_M:
        raise ValueError(
            f"saved state: depths.length holds {told:.3f} m where {length:.3f} m is right, as the string was"
        )


def length_of(state: State) -> float:
    """How long the topmost component was, with what was added to it, m; ValueError where that is not told."""
    for described in state.arrays:
        if described.name == LENGTH and (told := array_of(described)).size:
            return float(told[0])
    raise ValueError("the recorded state does not tell how long the string was")


def array_of(described: Array) -> NDArray[np.generic]:
    """The array that a message holds. Raises ValueError where it is not what it claims."""
    if not _NUMBERS.fullmatch(described.dtype):  # numpy would evaluate what else stands there
        raise ValueError(f"{described.name} is of {described.dtype!r}, which are no numbers")
    try:
        kind = np.dtype(described.dtype)
    except TypeError as error:
        raise ValueError(f"{described.name} is of {described.dtype!r}: {error}") from error
    if len(described.data) != math.prod(described.shape) * kind.itemsize:
        raise ValueError(f"{described.name} is not the {described.dtype}{tuple(described.shape)} it claims")
    return np.frombuffer(described.data, kind).reshape(tuple(described.shape))
