"""What the estimator is, and what it remembers: plain arrays, laid out once."""

import math
from typing import NamedTuple

import numpy as np

from vsensor.config import Bit
from vsensor.config import Tuning as Settings
from vsensor.estimator.along import Heard
from vsensor.estimator.gains import Gains
from vsensor.estimator.learn import Learned, fresh_law
from vsensor.estimator.ring import length_of
from vsensor.estimator.score import Scores, fresh_scores
from vsensor.estimator.sections import Floats, Integers, Line
from vsensor.estimator.tare import RAMP_S
from vsensor.estimator.tune import STRINGS, Tuning, fresh_tuning
from vsensor.jit import inlined

FLAGS = 16
"""Room for so many kinds of `quality.Reason`."""
TOP, BIT = range(2)
"""The two ends that have an inertia of their own."""
TORQUE, SPEED = range(2)
"""The two channels."""
NEXT, END, TOLD = range(3)
"""Of the march ahead: the next step of the one under way, its end, and that of what has been told of; ends
are not themselves in it."""
NONE = -1
"""There is no such march."""
NEVER = -(1 << 62)
"""When a flag was seen that has not been raised."""
FIRST_ROCK = 400.0
"""Torque of the rock beyond the load law, N·m, as it is taken to be at first."""


class Model(NamedTuple):
    """What does not change while running. Times in internal steps, `steps` of which make a tick."""

    line: Line
    """The model string; beside it run its shadows (tune.py), a little off: N strings in all."""
    impedances: Floats
    """ζ of each string's sections, N·m·s/rad, shape (N, M)."""
    round_trips: Integers
    """2θ of each string's sections, shape (N, M)."""
    mobilities: Floats
    """Of the junctions between each string's sections, rad/s for 1 N·m, shape (N, M − 1)."""
    drive_rates: Floats
    """2 J / Δt of each string's top drive, N·m·s/rad, shape (N,)."""
    off: Floats
    """By which share shadows are off in delay, in impedance and in inertia, shape (3,)."""
    inside: Integers
    """Steps for which a wave may be in its section, whatever the delay is corrected to, shape (M,)."""
    shift: int
    """Steps by which the bit is seen later with longer delays."""
    gains: Gains
    bit_rate: float
    """2 J / Δt of the bit, N·m·s/rad: what its inertia adds to an impedance (trapezoid rule)."""
    ringing: float
    """What those of two shadows have more and less of that: their strings ring lower and higher."""
    passed: float
    """String torque for one of motor torque: gear · efficiency."""
    turns: float
    """Motor turns for one of the string."""
    limits: tuple[float, float]
    """Motor torque, N·m, and speed, rad/s, beyond which a value is taken for missing."""
    noise: tuple[float, float]
    """What is told of motor torque's, N·m, and of speed's, rad/s; infinite where there is none."""
    rate: float
    """Ticks a second."""
    steps: int
    behind: int
    """Ticks by which the model string is behind the newest sample: torque is reported late."""
    late: float
    """How late, in ticks."""
    lag: int
    """Ticks for which later samples correct an answer before it is confirmed."""
    now: int
    """From the newest step of the model string to the present of the bit: the line's delay, and its own."""
    forecast: int
    """From there to the end of the forecast: at the most, the line's round trip."""
    horizons: Integers
    """From the newest step to those for which predictions are scored: now to the forecast, shape (H,)."""
    horizon: int
    """How far after the present the forecast may reach, in steps; the waves may end it sooner."""
    lasting: int
    """A bit that rests for so many steps sticks."""
    span: int
    """Ticks for which an input takes part in the confirmed answer."""
    fade: float
    """Share of the rock's torque left after an internal step."""
    shares: int
    """Ticks over which a march ahead is spread."""
    learns: bool
    """Whether the load law is learned, or stays as configured."""


class State(NamedTuple):
    """What changes from tick to tick; plain arrays, so that saving it is copying them."""

    inputs: Floats
    """Motor torque and speed of the last ticks, a ring, shape (2, ticks);"""
    missing: Integers
    """and whether each was missing, 0 or 1, same shape."""
    motor: Floats
    """What is held of each string against the torques of that ring, N·m, shape (N, ticks)."""
    waves: Floats
    """The wave f at the top of each section by internal step, of each string; rings, shape (N, M, size)."""
    returned: Floats
    """The wave g there, of the model string, before any correction; laid out alike, shape (M, size)."""
    innovations: Floats
    """What was heard since: the last innovations of that string by tick, 0 where none was; a ring,"""
    levels: Integers
    """and the level of the rock at each."""
    junctions: Floats
    """Speed of each junction at the newest step, 0 for one at rest, shape (N, M + 1)."""
    balances: Floats
    """J dω/dt of top drive and bit at that step, N·m, shape (N, 2)."""
    rock: Floats
    """What the rock asks beyond the load law, N·m, shape (N,)."""
    told: Floats
    """Answers by internal step: bit speed and torque, top speed and torque; a ring, shape (N, 4, size)."""
    innovation: Floats
    """What the measured speed says beyond each string's, rad/s; NaN without both channels, shape (N,)."""
    surprise: Floats
    """Mean square of the innovations over what was expected, shape (N,)."""
    off_bottom: Integers
    """Ticks for which the bit has been off bottom, or if negative, on it, shape (1,)."""
    held: Floats
    """Friction that resting parts of the wall may have held at each tick, N·m, a ring."""
    slips: Floats
    """Whether the string hangs in slips, and what of (slips.py), shape (3,)."""
    rock_square: Floats
    """Mean square of the rock's torque, (N·m)², shape (1,)."""
    level: Integers
    """Which of the gains are in force, shape (1,)."""
    steps: Floats
    """What is seen of the steps in which each channel is read (noise.py), shape (2, 3);"""
    resolution: Floats
    """how large they are, N·m and rad/s, 0 where none were seen, shape (2,)."""
    bends: Floats
    """What is seen of the lines between readings of speed (readings.py), shape (4,);"""
    lasts: Floats
    """how many ticks one reading stands for, 1 or more, shape (1,)."""
    white: Floats
    """Variance of what is white in the innovations, over what was expected, shape (1,)."""
    noisier: Floats
    """How much larger the variance of the channels' noise is than told, 1 or more, shape (1,)."""
    ticks: Integers
    """Ticks done, and the tick at which the waves were laid last, shape (2,)."""
    last_seen: Integers
    """The last tick at which each flag was raised, or NEVER, shape (FLAGS,)."""
    learned: Learned
    """The load law and what it was learned from."""
    scores: Scores
    """What was foretold, and how far it missed."""
    tuning: Tuning
    """What was learned of the configuration's own errors."""
    course: Integers
    """How far the march ahead has come (ahead.py), shape (3,);"""
    marching: Floats
    """each junction's speed in it,"""
    carried: Floats
    """and what else it carries from step to step (sweep.py), shape (2,)."""
    ahead: Floats
    """The bit's speed and torque as foretold, a ring by internal step, shape (2, size)."""
    unforeseen: Floats
    """Room for the variances of a prediction, shape (2,)."""


class Strand(NamedTuple):
    """What one of the strings has in a state, as views."""

    waves: Floats
    junctions: Floats
    balances: Floats
    rock: Floats
    told: Floats


@inlined
def strand(state: State, which: int) -> Strand:
    """One of the strings: the model's own is the first."""
    return Strand(
        state.waves[which],
        state.junctions[which],
        state.balances[which],
        state.rock[which : which + 1],
        state.told[which],
    )


@inlined
def line_of(model: Model, which: int) -> Line:
    """What one of the strings is made of."""
    line = model.line
    return Line(
        model.impedances[which],
        model.round_trips[which],
        line.viscous,
        line.kinetic,
        line.static,
        line.depth,
    )


def heard(model: Model, state: State) -> Heard:
    """What innovations have said of the model string's waves after those had left their sections."""
    gains, newest = model.gains, int(state.ticks[0]) - 1
    return Heard(
        gains.waves, model.inside, gains.returned, state.innovations, state.levels, newest, model.steps
    )


def fresh(model: Model, bit: Bit, settings: Settings) -> State:
    """The state before the first tick."""
    sections = len(model.line.impedance)
    # Whatever the delay is corrected to, no string's waves take longer there and back.
    longest = int(model.inside.sum())
    # Seen at one moment, the string's top is a travel time behind the last confirmed step, and waves
    # are looked up as far from there as the longest section reaches.
    ramp = 2 * math.ceil(RAMP_S * model.rate * model.steps)
    back = model.lag * model.steps + max(longest, ramp)
    half = longest // 2
    forecast = model.behind * model.steps + half + min(half, model.horizon)
    ahead = forecast + model.lasting + 2 * model.shares * model.steps
    size = length_of(ahead + back + model.steps)
    level = _first_level(model.gains.levels, bit)
    return State(
        inputs=np.zeros((2, model.behind + 3)),
        missing=np.zeros((2, model.behind + 3), np.int64),
        motor=np.zeros((STRINGS, model.behind + 3)),
        waves=np.zeros((STRINGS, sections, size)),
        returned=np.zeros((sections, size)),
        innovations=np.zeros(size // model.steps + 1),
        levels=np.zeros(size // model.steps + 1, np.int64),
        junctions=np.zeros((STRINGS, sections + 1)),
        balances=np.zeros((STRINGS, 2)),
        rock=np.zeros(STRINGS),
        told=np.zeros((STRINGS, 4, size)),
        innovation=np.full(STRINGS, np.nan),
        surprise=np.ones(STRINGS),
        off_bottom=np.zeros(1, np.int64),
        held=np.zeros(model.lag + 1),
        slips=np.zeros(3),
        rock_square=np.array([model.gains.levels[level] ** 2]),
        level=np.array([level]),
        steps=np.zeros((2, 3)),
        resolution=np.zeros(2),
        bends=np.zeros(4),
        lasts=np.ones(1),
        white=np.ones(1),
        noisier=np.ones(1),
        ticks=np.zeros(2, np.int64),
        last_seen=np.full(FLAGS, NEVER, np.int64),
        learned=fresh_law(bit),
        scores=fresh_scores(ahead // model.steps + model.lag + 2, model.rate),
        tuning=fresh_tuning(settings, model.passed),
        course=np.full(3, NONE, np.int64),
        marching=np.zeros(sections + 1),
        carried=np.zeros(2),
        ahead=np.zeros((2, length_of(ahead))),
        unforeseen=np.zeros(2),
    )


def _first_level(levels: Floats, bit: Bit) -> int:
    """Which of the levels is in force at first: half of what is guessed to hold the bit, at the most."""
    most = FIRST_ROCK if bit.static_torque == 0 else min(FIRST_ROCK, 0.5 * bit.static_torque)
    return int(np.argmin(np.abs(np.log(levels / most))))
