"""What the estimator is, and what it remembers: plain arrays, laid out once."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Bit
from vsensor.estimator.learn import Learned, fresh_law
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.estimator.top_drive import Smoothers

FLAGS = 16
"""Room for so many kinds of `quality.Reason`."""
TOP, BIT = range(2)
"""The two ends that have an inertia of their own."""
LEARNED = ("errors", "scored", *(f"learned.{name}" for name in Learned._fields))
"""What stays when the waves are lost."""


class Model(NamedTuple):
    """What does not change while running. Times in internal steps, `steps` of which make a tick."""

    line: Line
    bit_rate: float
    """2 J / Δt of the bit, N·m·s/rad: what its inertia adds to an impedance (trapezoid rule)."""
    smooth: Smoothers
    steps: int
    now: int
    """From a confirmed step to the present: the smoother's lag and the line's one-way delay."""
    forecast: int
    """From a confirmed step to the last that waves already sent reach: the lag and the line's round trip."""
    span: int
    """Ticks for which an input takes part in the confirmed answer."""
    memory: int
    """Ticks over which a prediction's running error forgets."""
    drive_rate: float
    """The same of the top drive."""
    rate: float
    """Ticks a second."""
    learns: bool
    """Whether the load law is learned, or stays as configured."""
    speed_std: float
    """Standard deviation that the measurement's noise gives the confirmed bit speed, rad/s."""
    torque_std: float
    """The same of its torque, N·m."""


class State(NamedTuple):
    """What changes from tick to tick; plain arrays, so that saving it is copying them."""

    torque: Floats
    """Motor torque, the window of the smoother written twice over, so that it is always in one piece."""
    speed: Floats
    waves: Floats
    """The wave f at the top of each section by internal step, shape (M, size), size a power of two."""
    returned: Floats
    """The wave g there, laid out alike, up to the last confirmed step."""
    junctions: Floats
    """Speed of each junction at the last confirmed step, 0 for one at rest, shape (M + 1,)."""
    top: Floats
    """Torque, N·m, and speed, rad/s, of the string's top at that step, shape (2,)."""
    balances: Floats
    """J dω/dt of top drive and bit at that step, N·m, shape (2,)."""
    confirmed: Floats
    """Bit speed and torque by internal step, a ring as long as that of the waves, shape (2, size)."""
    foretold: Floats
    """What each tick said of now and of the forecast, a ring, shape (2, 2, ticks)."""
    errors: Floats
    """Running mean square error of now and forecast, of speed and torque, shape (2, 2)."""
    scored: Integers
    """Predictions scored so far, of now and of the forecast, shape (2,)."""
    ticks: Integers
    """Ticks done, shape (1,)."""
    last_seen: Integers
    """The last tick at which each flag was raised, shape (FLAGS,)."""
    learned: Learned
    """The load law and what it was learned from."""
    marching: Floats
    """Room for the march: each junction's speed,"""
    told: Floats
    """and the bit's speed and torque at each of its steps, shape (2, steps)."""


def fresh(model: Model, bit: Bit) -> State:
    """The state before the first tick."""
    width = model.smooth.confirmed.speed_of_speed.shape[1]
    sections = len(model.line.impedance)
    end = max(model.forecast, model.smooth.lag * model.steps)
    # Seen at one moment, the string's top is a travel time behind the last confirmed step, and waves
    # are looked up as far from there as the longest section reaches.
    back = int(model.line.round_trip.sum())
    size = 1 << int(end + back + model.steps).bit_length()
    return State(
        torque=np.zeros(2 * width),
        speed=np.zeros(2 * width),
        waves=np.zeros((sections, size)),
        returned=np.zeros((sections, size)),
        junctions=np.zeros(sections + 1),
        top=np.zeros(2),
        balances=np.zeros(2),
        confirmed=np.zeros((2, size)),
        foretold=np.full((2, 2, end // model.steps + 2), np.nan),
        errors=np.zeros((2, 2)),
        scored=np.zeros(2, np.int64),
        ticks=np.zeros(1, np.int64),
        last_seen=np.full(FLAGS, -(1 << 62), np.int64),
        learned=fresh_law(bit),
        marching=np.zeros(sections + 1),
        told=np.zeros((2, end)),
    )


def flat(state: State) -> dict[str, NDArray[np.generic]]:
    """Copies of a state's arrays by name, those of the learned law as `learned.NAME`."""
    named = {name: array for name, array in state._asdict().items() if name != "learned"}
    learned = {f"learned.{name}": array for name, array in state.learned._asdict().items()}
    return {name: array.copy() for name, array in (named | learned).items()}


def fill(state: State, saved: Mapping[str, NDArray[np.generic]]) -> None:
    """Copy saved arrays into a state. Raises ValueError where one does not fit."""
    for name, array in saved.items():
        place = getattr(
            state.learned if name.startswith("learned.") else state, name.removeprefix("learned.")
        )
        if place.shape != array.shape or place.dtype != array.dtype:
            raise ValueError(
                f"saved state: {name} is {array.dtype}{array.shape}, the configuration asks for "
                f"{place.dtype}{place.shape}"
            )
        place[...] = array
