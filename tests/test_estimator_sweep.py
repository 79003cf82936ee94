"""The march far ahead must be the march step by step, to the bit."""

from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.strings import COLLAR, PIPE, strings
from vsensor.config import Bit, Component
from vsensor.estimator.line import march
from vsensor.estimator.load import Load, load_of
from vsensor.estimator.ring import SPARE
from vsensor.estimator.sections import Floats, Line, cut
from vsensor.estimator.sweep import SHORTEST, Span, sweep

STEP = 2e-3
SIZE = 4096
ROCK, FADE = 300.0, 0.98
SEEDS = st.integers(0, 2**32 - 1)


class Moment:
    """A string in motion at some step, its waves and its speeds drawn at random."""

    def __init__(self, line: Line, seed: int, wild: float, resting: float) -> None:
        random = np.random.default_rng(seed)
        sections = len(line.impedance)
        self.line = line
        self.known = int(random.integers(0, 10 * SIZE))
        turning = line.impedance[:, None] * (12 + wild * random.standard_normal((sections, SIZE + SPARE)))
        self.waves = turning + 4e3
        self.speeds = 12 + wild * random.standard_normal(sections + 1)
        self.speeds[random.random(sections + 1) < resting] = 0.0

    def swept(self, load: Load, *ends: int) -> tuple[Floats, Floats]:
        """What the bit does in a march with pauses at these steps, and where the junctions end up."""
        waves, speeds, told = self.waves.copy(), self.speeds.copy(), np.zeros((2, SIZE + SPARE))
        carried = np.array([ROCK, 0.0])
        first = self.known + 1
        for done, until in pairwise((0, *ends)):
            span = Span(self.known, first + done, first + until, first + ends[-1])
            sweep(self.line, load, waves, span, FADE, speeds, carried, told)
        return told[:, (first + np.arange(ends[-1])) % SIZE], speeds

    def marched(self, load: Load, steps: int) -> tuple[Floats, Floats]:
        """The same step by step, no junction spared."""
        waves, speeds, told = self.waves.copy(), self.speeds.copy(), np.zeros((2, steps))
        one, external, balance, mask = np.zeros((2, 1)), ROCK, 0.0, SIZE - 1
        for k in range(steps):
            step = self.known + 1 + k
            _, balance = march(self.line, load, waves, step, external, speeds, balance, one, 0)
            told[:, k] = one[:, 0]
            waves[0, step & mask] = waves[0, self.known & mask]
            external *= FADE
        return told, speeds


@settings(max_examples=40)
@given(strings(), SEEDS, st.lists(st.integers(1, 700), min_size=1), st.floats(0, 20), st.floats(0, 0.5))
def test_any_string_in_any_motion(
    string: tuple[Component, ...], seed: int, ends: list[int], wild: float, resting: float
) -> None:
    line = cut(string, STEP, 300)
    bit = Bit(inertia=50, viscous_friction=5, kinetic_torque=3e3, static_torque=8e3, stribeck_speed=1.5)
    moment, load = Moment(line, seed, wild, resting), load_of(bit, STEP)
    told, _ = moment.swept(load, *sorted(ends))
    np.testing.assert_array_equal(told, moment.marched(load, max(ends))[0])


def test_all_junctions_turn_as_far_as_they_matter() -> None:
    """A junction is passed until its wave would come to the bit too late, and no further."""
    line = cut((PIPE, COLLAR), STEP, 300)
    assert line.round_trip.min() >= SHORTEST
    moment, load = Moment(line, 7, 0.5, 0.0), load_of(Bit(viscous_friction=20), STEP)
    steps = int(line.round_trip[1:].sum()) + 50
    _, swept = moment.swept(load, steps)
    for junction in range(1, len(line.impedance)):
        matters = steps - int(line.round_trip[junction:].sum())
        _, marched = moment.marched(load, matters)
        assert swept[junction] == marched[junction]
