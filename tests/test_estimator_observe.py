"""The observer: on strings that are as assumed it is right, and on others nothing worse than inexact."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.observer import ALONE, LINEAR, LOSSY, drilled, innovations, pinned
from tests.strings import COLLAR, PIPE, rig
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.gains import ROCK_LEVELS
from vsensor.estimator.kernel import CONFIRMED, SPEED, SPEED_STD, TORQUE, TORQUE_STD
from vsensor.estimator.sections import Floats
from vsensor.jit import COMPILED

needs_compiler = pytest.mark.skipif(not COMPILED, reason="long records: too slow without the compiler")
LEVEL = 4
ROCK = float(ROCK_LEVELS[LEVEL])
CHANGING = 5e3 + 2e3 * np.sin(np.arange(820) / 17.0)
TICKS = 4000


@pytest.fixture(scope="module")
def long() -> tuple[Estimator, Floats, Floats, Floats]:
    """A linear string with exactly the noise assumed: innovations, answers, and what was true of them."""
    record = drilled(LINEAR, np.full(TICKS, 4e3), ROCK, 3)
    estimator = pinned(LINEAR, LEVEL)
    told = innovations(estimator, record)
    estimator.reset()
    answers = estimator.run(record.torque, record.speed).values
    truth = np.array([record.bit_speed, record.bit_torque])
    return estimator, told, answers, truth


def late(estimator: Estimator, truth: Floats) -> Floats:
    """Truth at the ticks at which it is confirmed: the last correction comes `lag` ticks less one later."""
    shift = round(LINEAR.estimator.lag * LINEAR.loop.rate)
    return np.concatenate([np.full((2, shift), np.nan), truth[:, :-shift]], axis=1)


@needs_compiler
def test_innovations_are_white_and_as_large_as_stated(long: tuple[Estimator, Floats, Floats, Floats]) -> None:
    estimator, told, _, _ = long
    told = told[400:]
    expected = math.sqrt(estimator._model.gains.innovation[0])
    assert told.std() == pytest.approx(expected, rel=0.06)
    for apart in (1, 2, 3, 5, 8, 13, 20):
        correlation = np.mean(told[apart:] * told[:-apart]) / np.mean(told**2)
        assert abs(correlation) < 4 / math.sqrt(len(told)), apart


@needs_compiler
def test_the_confirmed_error_is_as_large_as_stated(long: tuple[Estimator, Floats, Floats, Floats]) -> None:
    estimator, _, answers, truth = long
    expected = late(estimator, truth)
    for q, (value, deviation) in enumerate(((SPEED, SPEED_STD), (TORQUE, TORQUE_STD))):
        error = (answers[:, CONFIRMED + value] - expected[q])[400:]
        assert error.std() == pytest.approx(np.median(answers[400:, CONFIRMED + deviation]), rel=0.12)
        assert abs(error.mean()) < 0.3 * error.std()


@needs_compiler
def test_without_noise_the_truth_is_found() -> None:
    """A linear string that is as configured, and a rock that is its law: after the start nothing is left."""
    record = drilled(LINEAR, CHANGING, 0.0, 1, noisy=False)
    estimator = pinned(LINEAR, LEVEL)
    values = estimator.run(record.torque, record.speed).values
    truth = late(estimator, np.array([record.bit_speed, record.bit_torque]))
    settled = slice(700, None)
    assert np.ptp(truth[0, settled]) > 4
    np.testing.assert_allclose(values[settled, CONFIRMED + SPEED], truth[0, settled], atol=0.01)
    np.testing.assert_allclose(values[settled, CONFIRMED + TORQUE], truth[1, settled], atol=5.0)


@needs_compiler
@pytest.mark.parametrize("speed", [0.0, 9.0])
def test_a_string_in_steady_rotation_or_at_rest_starts_without_a_transient(speed: float) -> None:
    rough = LOSSY.model_copy(update={"coulomb_friction": 0.5, "static_friction": 0.8})
    bit = {"viscous_friction": 50.0, "kinetic_torque": 1e3, "static_torque": 1e3}
    of = rig(rough, COLLAR, rate=20.0, bit=bit, estimator={"learn": False}, tuning=ALONE)
    wall = LOSSY.length * (0.1 * speed + 0.5)
    torque = wall + 1e3 + 50.0 * speed if speed else 300.0
    estimator = Estimator(of)
    torques, speeds = np.full(200, torque), np.full(200, speed)
    values = estimator.run(torques, speeds).values
    told = values[np.isfinite(values[:, CONFIRMED])]
    assert len(told) > 100
    np.testing.assert_allclose(told[:, CONFIRMED + SPEED], speed, atol=1e-6)
    if speed:
        np.testing.assert_allclose(told[:, CONFIRMED + TORQUE], 1e3 + 50.0 * speed, atol=1e-3)


@needs_compiler
@pytest.mark.parametrize("channel", [0, 1])
def test_where_one_channel_is_lost_the_string_runs_on_and_its_return_is_seamless(channel: int) -> None:
    record = drilled(LINEAR, CHANGING, 0.0, 1, noisy=False)
    inputs = [record.torque.copy(), record.speed.copy()]
    inputs[channel][300:360] = math.nan
    estimator = pinned(LINEAR, LEVEL)
    values = estimator.run(*inputs).values
    truth = late(estimator, np.array([record.bit_speed, record.bit_torque]))
    error = np.abs(values[:, CONFIRMED + SPEED] - truth[0])
    assert np.isfinite(error[200:]).all()
    # All that it lacks is what the model did not know yet when the channel fell silent.
    assert error[300:].max() < 0.02 * np.ptp(truth[0, 200:])
    assert error[720:].max() < 0.01


@needs_compiler
@pytest.mark.parametrize(("torque", "speed"), [(1.5e5, 0.0), (0.0, 50.0), (-1e5, -40.0)])
def test_a_wild_sample_does_limited_harm(torque: float, speed: float) -> None:
    record = drilled(LINEAR, np.full(800, 4e3), ROCK, 5)
    wild = [record.torque.copy(), record.speed.copy()]
    wild[0][400] += torque
    wild[1][400] += speed
    estimator = pinned(LINEAR, LEVEL)
    calm = estimator.run(record.torque, record.speed).values[:, CONFIRMED : CONFIRMED + 3 : 2]
    estimator.reset()
    values = estimator.run(*wild).values[:, CONFIRMED : CONFIRMED + 3 : 2]
    # One tick of a torque turns a whole rig by so much, whoever watches it.
    turned = abs(torque) / LINEAR.loop.rate / LINEAR.top_drive.inertia
    harm = np.abs(values - calm)
    assert np.nanmax(harm[:, 0]) < 6.0 + 4 * turned
    assert harm[700:, 0].max() < 0.1 + 0.02 * turned
    assert harm[700:, 1].max() < 60


@needs_compiler
def test_a_bit_at_rest_stays_exactly_at_rest_whatever_the_noise_says() -> None:
    bit = {"inertia": 50.0, "viscous_friction": 50.0, "kinetic_torque": 6e3, "static_torque": 20e3}
    of = rig(LOSSY, COLLAR, rate=20.0, bit=bit, top_drive={"inertia": 800.0, "torque_lag": 0.0})
    record = drilled(of, np.full(600, 5e3), 0.0, 2)
    assert (record.bit_speed == 0).all()
    values = Estimator(of).run(record.torque, record.speed).values
    told = values[np.isfinite(values[:, CONFIRMED])]
    assert (told[:, CONFIRMED + SPEED] == 0).all()
    assert told[-200:, CONFIRMED + TORQUE].mean() == pytest.approx(5e3, rel=0.03)


@needs_compiler
@settings(max_examples=5)
@given(st.integers(0, 2**32 - 1), st.integers(0, len(ROCK_LEVELS) - 1))
def test_corrections_never_feed_on_themselves(seed: int, level: int) -> None:
    """Whichever gains are in force, and whatever came in, it is forgotten."""
    random = np.random.default_rng(seed)
    estimator = pinned(LINEAR, level)
    estimator.run(3e4 * random.standard_normal(40), 20 * random.standard_normal(40))
    calm = np.abs(estimator.run(np.zeros(1200), np.zeros(1200)).values[:, CONFIRMED + SPEED])
    assert calm[-200:].max() < 0.5 * calm[50:250].max()


@needs_compiler
@pytest.mark.parametrize("level", [0, 4])
def test_a_top_without_inertia_is_not_driven_by_the_noise_of_its_last_sample(level: int) -> None:
    """The next tick's torque begins at that sample; left as it was measured, it drove the string away."""
    of = rig(PIPE, rate=50.0, bit={"inertia": 50.0, "viscous_friction": 60.0}, tuning=ALONE)
    assert of.top_drive.inertia == 0
    assert _grown(pinned(of, level)) < 1


@needs_compiler
def test_a_string_without_any_loss_is_not_driven_by_its_corrections_either() -> None:
    free = PIPE.model_copy(update={"length": 600.0, "viscous_friction": 0.0})
    bit, drive = {"inertia": 50.0, "viscous_friction": 40.0}, {"inertia": 200.0}
    of = rig(free, rate=20.0, bit=bit, top_drive=drive, tuning=ALONE, estimator={"learn": False})
    assert _grown(pinned(of, len(ROCK_LEVELS) - 1)) < 1


def _grown(estimator: Estimator) -> float:
    """What is left half a minute later of what a burst of noise left behind."""
    random = np.random.default_rng(1)
    estimator.run(300 * random.standard_normal(200), 0.1 * random.standard_normal(200))
    ticks = 1600
    swing = np.abs(estimator.run(np.zeros(ticks), np.zeros(ticks)).values[:, CONFIRMED + SPEED])
    return float(swing[-ticks // 4 :].max() / swing[ticks // 4 : ticks // 2].max())
