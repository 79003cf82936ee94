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
    """Go on from a recorded state. Raises ValueError where it does not fit this configuration or version."""
    try:
        saved = {described.name: array_of(described) for described in state.arrays}
        held = json.loads(state.intake)
    except ValueError as error:
        raise ValueError(f"the recorded state cannot be read: {error}") from error
    estimator.restore(saved)
    try:
        intake.restore(held)
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"the recorded state of the intake is of another version: {error}") from error


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
