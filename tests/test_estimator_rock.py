"""How restless the rock is: found from the innovations of a rock that is known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.observer import LINEAR, drilled, pinned
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.gains import ROCK_LEVELS
from vsensor.estimator.rock import hang_together, weigh_rock
from vsensor.estimator.sections import Floats
from vsensor.jit import COMPILED

RATE = LINEAR.loop.rate
LEVEL = 5
"""A rock of 400 N·m."""


def rocks(estimator: Estimator, true: float, seconds: float = 240.0) -> Floats:
    """The rock's deviation as held tick by tick, from a minute on, where it truly is `true`, N·m."""
    record = drilled(LINEAR, np.full(round(seconds * RATE), 4e3), true, seed=5)
    held = []
    for torque, speed in zip(record.torque, record.speed, strict=True):
        estimator.step(float(torque), float(speed))
        held.append(estimator.rock_std)
    return np.array(held[round(60 * RATE) :])


@pytest.mark.skipif(not COMPILED, reason="hours of ticks: too slow without the compiler")
@pytest.mark.parametrize("level", range(len(ROCK_LEVELS)))
def test_the_gains_follow_the_rocks_restlessness(level: int) -> None:
    """The least of them are drowned in the noise: what is known of those is that they are small."""
    found = np.median(rocks(Estimator(LINEAR), float(ROCK_LEVELS[level])))
    nearest = int(np.argmin(np.abs(np.log(ROCK_LEVELS / found))))
    assert abs(nearest - level) <= 1 if level > 2 else nearest <= 3


@pytest.mark.skipif(not COMPILED, reason="hours of ticks: too slow without the compiler")
@pytest.mark.parametrize("times", [0.7, 1.0, 1.4])
def test_near_the_level_in_force_it_is_told_without_bias(times: float) -> None:
    true = times * float(ROCK_LEVELS[LEVEL])
    assert math.sqrt(np.mean(rocks(pinned(LINEAR, LEVEL), true, 1200.0) ** 2)) == pytest.approx(
        true, rel=0.15
    )


@pytest.fixture(scope="module")
def linear() -> Estimator:
    return Estimator(LINEAR)


@pytest.fixture
def estimator(linear: Estimator) -> Estimator:
    """As made anew: only its state changes while it is used."""
    linear.reset()
    linear._state.junctions[0, -1] = 10.0
    return linear


def weighed(estimator: Estimator, innovations: Floats) -> float:
    """The rock's deviation after these innovations, N·m."""
    state = estimator._state
    for one in innovations.tolist():
        state.innovation[0] = state.innovations[state.ticks[0] % len(state.innovations)] = one
        weigh_rock(estimator._model, state)
        state.ticks[0] += 1
    return estimator.rock_std


def test_innovations_that_do_not_hang_together_are_no_rock_however_large(estimator: Estimator) -> None:
    """As of a reading that is noisier than was told: three times, and its square is known."""
    usual = math.sqrt(float(estimator._model.gains.innovation[estimator._state.level[0]]))
    estimator._state.surprise[0] = 9.0
    white = 3 * usual * np.random.default_rng(1).standard_normal(round(30 * RATE))
    before = estimator.rock_std
    assert weighed(estimator, white) < 1.5 * before


@pytest.mark.parametrize("wild", [1e3, -1e3])
def test_one_wild_innovation_makes_no_other_rock(estimator: Estimator, wild: float) -> None:
    assert weighed(estimator, np.array([wild])) <= 4 * ROCK_LEVELS[LEVEL] * (1 + 1e-9)


def test_a_bit_that_hardly_turns_says_nothing_of_the_rock(estimator: Estimator) -> None:
    before = estimator.rock_std
    estimator._state.junctions[0, -1] = 0.3
    assert weighed(estimator, np.ones(50)) == before


def test_nor_does_an_innovation_where_none_tells_of_it() -> None:
    """A bit that is too heavy for any rock."""
    estimator = Estimator(LINEAR)
    estimator._state.junctions[0, -1] = 10.0
    model = estimator._model
    mute = model.gains._replace(
        traces=np.zeros_like(model.gains.traces), telling=np.zeros_like(model.gains.telling)
    )
    estimator._run_by(model._replace(gains=mute))
    before = estimator.rock_std
    assert weighed(estimator, np.ones(50)) == before


def test_nor_does_a_tick_without_a_reading(estimator: Estimator) -> None:
    before = estimator.rock_std
    assert weighed(estimator, np.full(50, np.nan)) == before


@given(st.integers(0, 500), st.integers(1, 20), st.integers(20, 40), st.integers(0, 2**32 - 1))
def test_how_innovations_hang_together_is_read_round_their_ring(
    tick: int, lags: int, size: int, seed: int
) -> None:
    random = np.random.default_rng(seed)
    traces, ring = random.standard_normal(lags), random.standard_normal(size)
    naive = traces[0] * ring[tick % size]
    naive += 2 * sum(traces[n] * ring[(tick - n) % size] for n in range(1, lags))
    assert hang_together(traces, ring, tick) == pytest.approx(naive, rel=1e-9, abs=1e-9)
