"""Strings that go side by side come to the bits of each on its own."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.strings import BIT, COLLAR, DRIVE, PIPE, rig
from vsensor.estimator.component import delay
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.learn import load_in_force
from vsensor.estimator.line import march
from vsensor.estimator.load import Load
from vsensor.estimator.ring import mask_of
from vsensor.estimator.rise import rise
from vsensor.estimator.state import BIT as BIT_END
from vsensor.estimator.state import Model, State, fresh
from vsensor.estimator.tune import LATER, SOONER

STRING = rig(PIPE, COLLAR, bit=BIT, top_drive=DRIVE)
STEPS = 200


@pytest.fixture(scope="module")
def estimator() -> Estimator:
    return Estimator(STRING)


def in_motion(model: Model, seed: int, resting: float) -> State:
    """All strings, each with waves and speeds of its own, some junctions at rest."""
    random = np.random.default_rng(seed)
    state = fresh(model, STRING.bit, STRING.tuning)
    state.waves[...] = 4e3 + 3e3 * random.standard_normal(state.waves.shape)
    state.junctions[...] = 12 + 6 * random.standard_normal(state.junctions.shape)
    state.junctions[random.random(state.junctions.shape) < resting] = 0.0
    state.rock[...] = 300 * random.standard_normal(state.rock.shape)
    return state


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.floats(0, 0.5), st.integers(0, 10_000), st.sampled_from((1.0, 1e3)))
def test_each_string_marches_as_if_it_were_alone(
    estimator: Estimator, seed: int, resting: float, first: int, unsure: float
) -> None:
    """A bit that is light beside what is unsure keeps half of its inertia."""
    model = estimator._model._replace(ringing=unsure * estimator._model.ringing)
    together, alone = in_motion(model, seed, resting), in_motion(model, seed, resting)
    load = load_in_force(together.learned, model.bit_rate)
    rock = float(np.sqrt(together.rock_square[0]))
    loads = [load] * len(alone.waves)
    lighter = max(load.inertia_rate - model.ringing, load.inertia_rate / 2)
    loads[LATER] = load._replace(static=load.static + rock, inertia_rate=load.inertia_rate + model.ringing)
    loads[SOONER] = load._replace(static=load.static - rock, inertia_rate=lighter)
    mask = mask_of(together.waves.shape[2])
    for step in range(first, first + STEPS):
        rise(model, load, together, step)
        for which, waves in enumerate(alone.waves):
            line = model.line._replace(impedance=model.impedances[which], round_trip=model.round_trips[which])
            balances, now = alone.balances[which], step & mask
            g, balances[BIT_END] = march(
                line,
                loads[which],
                waves,
                step,
                alone.rock[which],
                alone.junctions[which],
                balances[BIT_END],
                alone.told[which],
                now,
            )
            assert together.waves[which, 0, now] == g
            waves[0, now] = together.waves[which, 0, now] = 4e3 + 100 * np.sin(step)
    for name in ("waves", "junctions", "balances", "told"):
        np.testing.assert_array_equal(getattr(together, name), getattr(alone, name))
    assert (together.junctions[1:] != together.junctions[0]).any()


def test_the_collars_ring_as_much_lower_as_their_length_is_unsure(estimator: Estimator) -> None:
    """Free at the top but for thin pipe, with a mass m at their end: tan ωT = −ωm/ζ (Rayleigh 1894, 171)."""
    model, rate = estimator._model, STRING.loop.rate * estimator.steps_per_tick
    travel, mass = model.round_trips[0, -1] / 2 / rate, model.ringing / 2 / rate  # of the collars alone
    omega = np.linspace(0.9, 1.0, 100_001) * np.pi / travel
    pitch = omega[np.argmin(np.abs(np.tan(omega * travel) + omega * mass / model.impedances[0, -1]))]
    unsure = np.hypot(STRING.tuning.delay, travel / delay(COLLAR) - 1)
    assert 1 - pitch * travel / np.pi == pytest.approx(unsure, rel=0.05)


def test_where_there_is_no_rock_nothing_breaks_loose(estimator: Estimator) -> None:
    model = estimator._model._replace(ringing=0.0)
    state = in_motion(model, 1, 0.0)
    for each in (state.waves, state.junctions, state.rock):
        each[...] = each[0]
    for step in range(STEPS):
        rise(model, Load(0.0, 0.0, 0.0, 1.0, model.bit_rate), state, step)
    assert np.ptp(state.told[0]) > 0
    for which in (LATER, SOONER):
        np.testing.assert_array_equal(state.told[which], state.told[0])
