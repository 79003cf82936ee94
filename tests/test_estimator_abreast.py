"""Ticks that march side by side answer to the bits of ticks one by one, whatever they are fed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.strings import BIT, COLLAR, DRIVE, PIPE, rig, strings
from tests.test_estimator import record, same
from vsensor.bench.well import deep_well
from vsensor.config import Component, Rig, Tuning
from vsensor.estimator.abreast import WORTHWHILE, most_abreast
from vsensor.estimator.bits import LANES
from vsensor.estimator.estimator import Estimates, Estimator
from vsensor.estimator.kernel import FORECAST, NO_FORECAST, OFF_BOTTOM, SPEED
from vsensor.estimator.score import NOW
from vsensor.estimator.sections import Floats
from vsensor.estimator.study import foretold_for
from vsensor.jit import COMPILED
from vsensor.quality import Reason
from vsensor.simulate.scenario import Scenario

if not COMPILED:
    pytest.skip("ticks march side by side only as compiled", allow_module_level=True)

LONG = rig(PIPE.model_copy(update={"length": 2500.0}), COLLAR, bit=BIT, top_drive=DRIVE)
STUCK = record(LONG, Scenario.STICK_SLIP, 25.0)
TORQUES, SPEEDS = np.ascontiguousarray(STUCK[:, 1]), np.ascontiguousarray(STUCK[:, 2])
BEFORE, AFTER = 1500, 700
"""Ticks in good order, until everything is told, and those of which anything may come."""
FLAGS = [0, 0, OFF_BOTTOM, NO_FORECAST, OFF_BOTTOM | NO_FORECAST, int(Reason.STRING_CHANGED)]


def alone(estimator: Estimator, torques: Floats, speeds: Floats, flags: NDArray[np.uint32]) -> Estimates:
    """The same ticks, but so few in a call that none waits for another."""
    parts = [
        estimator.run(*(column[k : k + WORTHWHILE] for column in (torques, speeds, flags)))
        for k in range(0, len(torques), WORTHWHILE)
    ]
    return Estimates(
        np.concatenate([part.values for part in parts]),
        np.concatenate([part.reasons for part in parts]),
        np.concatenate([part.delays for part in parts], axis=1),
    )


def both_ways(of: Rig, torques: Floats, speeds: Floats) -> tuple[Estimates, Estimates]:
    flags = np.zeros(len(torques), np.uint32)
    return Estimator(of).run(torques, speeds, flags), alone(Estimator(of), torques, speeds, flags)


@pytest.fixture(scope="module")
def estimator() -> Estimator:
    return Estimator(LONG)


@pytest.fixture(scope="module")
def warm(estimator: Estimator) -> dict[str, NDArray[np.generic]]:
    assert most_abreast(estimator._model) == LANES
    told = estimator.run(TORQUES[:BEFORE], SPEEDS[:BEFORE]).values
    assert np.isfinite(told[-1, : FORECAST + 4]).all()
    return estimator.save()


@settings(max_examples=25)
@given(st.data())
def test_whatever_comes_the_bits_are_the_same(
    estimator: Estimator, warm: dict[str, NDArray[np.generic]], data: st.DataObject
) -> None:
    places = st.integers(0, AFTER - 1)
    torques, speeds = TORQUES[BEFORE : BEFORE + AFTER].copy(), SPEEDS[BEFORE : BEFORE + AFTER].copy()
    for column in (torques, speeds):
        for place in data.draw(st.lists(places, max_size=3)):
            lasting = data.draw(st.integers(1, 40))
            column[place : place + lasting] = data.draw(st.sampled_from([np.nan, np.inf, -1e12, 0.0, 3e4]))
    flags = np.zeros(AFTER, np.uint32)
    for place in data.draw(st.lists(places, max_size=5)):
        flags[place:] = data.draw(st.sampled_from(FLAGS))
    estimator.restore(warm)
    abreast = estimator.run(torques, speeds, flags)
    estimator.restore(warm)
    assert same(abreast, alone(estimator, torques, speeds, flags))


@pytest.mark.parametrize("of", [deep_well(100.0), LONG.model_copy(update={"tuning": Tuning(delay=0.1)})])
def test_the_bits_are_the_same_of_a_deep_well_and_where_delays_are_corrected(of: Rig) -> None:
    softer = [part.model_copy(update={"shear_modulus": 0.9 * part.shear_modulus}) for part in of.string]
    drilling = record(of.model_copy(update={"string": tuple(softer)}), Scenario.STICK_SLIP, 25.0)
    one, other = both_ways(of, *np.ascontiguousarray(drilling[:, 1:3].T))
    assert np.isfinite(one.values[-1, FORECAST + SPEED])
    assert same(one, other)


@settings(max_examples=15)
@given(strings(most=4), st.sampled_from([10.0, 50.0, 100.0, 400.0]), st.floats(0.01, 1.0), st.floats(0, 30))
def test_the_bits_are_the_same_of_any_string(
    string: tuple[Component, ...], rate: float, lag: float, swing: float
) -> None:
    of = rig(*string, bit=BIT, top_drive=DRIVE, rate=rate, estimator={"lag": lag})
    seconds = np.arange(round(8 * rate)) / rate
    torques, speeds = 6e3 + 100 * swing * np.sin(3 * seconds), 12.0 + swing * np.sin(2 * seconds)
    assert same(*both_ways(of, torques, speeds))


@settings(max_examples=10)
@given(strings(most=4), st.sampled_from([50.0, 100.0]), st.floats(0.01, 1.0))
def test_what_a_tick_foretells_is_there_before_it_is_scored(
    string: tuple[Component, ...], rate: float, lag: float
) -> None:
    estimator = Estimator(rig(*string, rate=rate, estimator={"lag": lag}))
    model, state = estimator._model, estimator._state
    state.ticks[0] = 10_000
    scored, _ = foretold_for(model, state, NOW)
    assert 1 <= most_abreast(model) <= 10_000 - scored
