"""The load law is learned from the bit's own confirmed answers."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsensor.config import Bit
from vsensor.estimator.learn import Learned, fresh_law, learn, lose_sight
from vsensor.estimator.sections import Floats
from vsensor.jit import COMPILED

needs_compiler = pytest.mark.skipif(not COMPILED, reason="long records: too slow without the compiler")

RATE = 100.0
ROCK = Bit(viscous_friction=12, kinetic_torque=2500, static_torque=6000, stribeck_speed=1.5)
GUESS = Bit(viscous_friction=5, kinetic_torque=1000, static_torque=1500, stribeck_speed=1.0)


def torque_of(bit: Bit, speed: Floats) -> Floats:
    fall = (bit.static_torque - bit.kinetic_torque) * np.exp(-speed / bit.stribeck_speed)
    return np.asarray(bit.viscous_friction * speed + bit.kinetic_torque + fall)


def feed(learned: Learned, speeds: Floats, torques: Floats, held: float = 0.0) -> None:
    for tick, (speed, torque) in enumerate(zip(speeds, torques, strict=True)):
        learn(learned, held, float(speed), float(torque), RATE, tick)


def told(learned: Learned, speed: float) -> float:
    viscous, kinetic, static, stribeck = learned.law
    return float(viscous * speed + kinetic + (static - kinetic) * np.exp(-speed / stribeck))


def swinging(seconds: float, seed: int = 1) -> tuple[Floats, Floats]:
    """A bit that swings between 1 and 20 rad/s, its torque with the noise of a confirmed answer."""
    random = np.random.default_rng(seed)
    time = np.arange(round(seconds * RATE)) / RATE
    speeds = 10.5 + 9.5 * np.sin(2 * np.pi * time / 5)
    return speeds, torque_of(ROCK, speeds) + 250 * random.standard_normal(len(time))


@pytest.mark.parametrize("guess", [GUESS, Bit(), ROCK])
def test_half_a_minute_of_swinging_tells_the_law_wherever_it_began(guess: Bit) -> None:
    learned = fresh_law(guess)
    feed(learned, *swinging(30))
    for speed in (2.0, 5.0, 10.0, 20.0):
        assert told(learned, speed) == pytest.approx(float(torque_of(ROCK, np.array(speed))), rel=0.05)


def test_one_in_ten_wild_pairs_does_not_sway_it() -> None:
    learned = fresh_law(GUESS)
    speeds, torques = swinging(40)
    torques[::10] += 15e3
    feed(learned, speeds, torques)
    for speed in (2.0, 5.0, 15.0):
        assert told(learned, speed) == pytest.approx(float(torque_of(ROCK, np.array(speed))), rel=0.12)


def test_a_stick_tells_the_static_torque() -> None:
    learned = fresh_law(GUESS)
    ramp = np.linspace(2e3, 6e3, 200)
    slip = np.linspace(15, 1.6, 200)
    for _ in range(6):
        feed(learned, np.zeros(200), ramp)
        feed(learned, slip, torque_of(ROCK, slip))
    assert learned.law[2] == pytest.approx(6000, rel=0.1)


def test_torque_that_a_resting_wall_may_hold_is_not_laid_on_the_bit() -> None:
    """A string that breaks loose after a connection: the bit's torque is unknown by the wall's."""
    learned = fresh_law(Bit())
    feed(learned, np.zeros(300), np.full(300, 9e3), held=9e3)
    feed(learned, np.full(300, 8.0), np.zeros(300))
    assert learned.law[2] < 300


@needs_compiler
def test_new_rock_replaces_the_old() -> None:
    learned = fresh_law(GUESS)
    feed(learned, *swinging(60))
    speeds, torques = swinging(120, seed=2)
    feed(learned, speeds, 0.5 * torques)
    assert told(learned, 10.0) == pytest.approx(0.5 * float(torque_of(ROCK, np.array(10.0))), rel=0.15)


def whims(seconds: float, seed: int) -> Floats:
    """Torque of rough rock, N·m: 500 rms, forgotten within 0.3 s."""
    keep = math.exp(-1 / (0.3 * RATE))
    kicks = (
        500 * math.sqrt(1 - keep * keep) * np.random.default_rng(seed).standard_normal(round(seconds * RATE))
    )
    torques = np.zeros(len(kicks))
    for k in range(1, len(kicks)):
        torques[k] = keep * torques[k - 1] + kicks[k]
    return torques


@needs_compiler
@pytest.mark.parametrize(("before", "after"), [(0.2, 1.0), (1.0, 0.4), (1.0, 1.6)])
def test_weight_set_on_the_bit_is_learned_within_seconds(before: float, after: float) -> None:
    """After two minutes under another weight: these are no reason to hold on to it for two more."""
    learned = fresh_law(ROCK)
    told_before = before * torque_of(ROCK, np.full(12_000, 11.0)) + whims(120, 5)
    feed(learned, np.full(12_000, 11.0), told_before)
    feed(learned, np.full(1200, 11.0), after * torque_of(ROCK, np.full(1200, 11.0)) + whims(12, 6))
    assert told(learned, 11.0) == pytest.approx(after * float(torque_of(ROCK, np.array(11.0))), abs=400)


@needs_compiler
def test_a_swinging_bit_learns_new_rock_within_two_swings() -> None:
    learned = fresh_law(GUESS)
    feed(learned, *swinging(90))
    speeds, torques = swinging(10, seed=2)
    feed(learned, speeds, 1.6 * torques)
    for speed in (2.0, 5.0, 15.0):
        assert told(learned, speed) == pytest.approx(1.6 * float(torque_of(ROCK, np.array(speed))), rel=0.1)


@needs_compiler
def test_the_whims_of_rough_rock_are_no_new_rock() -> None:
    """What is told after three minutes of them is the mean of the last minute, not of some seconds."""
    misses = []
    for seed in range(8):
        learned = fresh_law(ROCK)
        feed(learned, np.full(18_000, 11.0), torque_of(ROCK, np.full(18_000, 11.0)) + whims(180, seed))
        misses.append(told(learned, 11.0) - float(torque_of(ROCK, np.array(11.0))))
    # 500 N·m over 60 s that are forgotten evenly: 500 √(0.3/60) = 35 N·m; over 3 s it would be 160.
    assert np.sqrt(np.mean(np.square(misses))) < 70


@needs_compiler
def test_steady_drilling_leaves_what_it_cannot_tell_as_it_was() -> None:
    learned = fresh_law(ROCK)
    steady = np.full(12_000, 12.0)
    feed(learned, steady, torque_of(ROCK, steady))
    assert learned.law == pytest.approx(
        [ROCK.viscous_friction, ROCK.kinetic_torque, ROCK.static_torque, ROCK.stribeck_speed], rel=0.35
    )
    assert told(learned, 12.0) == pytest.approx(float(torque_of(ROCK, np.array(12.0))), rel=0.01)


@settings(max_examples=25)
@given(st.lists(st.tuples(st.floats(-60, 60), st.floats(-5e4, 5e4)), min_size=1, max_size=200))
def test_whatever_it_is_fed_the_law_resists(pairs: list[tuple[float, float]]) -> None:
    """A law that drove the bit would break the string's passivity."""
    learned = fresh_law(GUESS)
    feed(learned, *np.array(pairs * 3).T)
    viscous, kinetic, static, stribeck = learned.law
    assert np.isfinite(learned.law).all()
    assert viscous >= 0
    assert 0 <= kinetic <= static
    assert stribeck > 0


@needs_compiler
def test_noise_at_one_speed_tells_nothing_of_rest_nor_of_how_the_law_falls() -> None:
    random = np.random.default_rng(4)
    learned = fresh_law(ROCK)
    speeds = 10 + 0.15 * random.standard_normal(9000)
    feed(learned, speeds, torque_of(ROCK, speeds) + 900 + 250 * random.standard_normal(9000))
    assert learned.law[2] == pytest.approx(ROCK.static_torque, rel=0.02)
    assert learned.law[3] == ROCK.stribeck_speed
    assert told(learned, 10.0) == pytest.approx(float(torque_of(ROCK, np.array(10.0))) + 900, rel=0.02)


def test_a_configured_stribeck_speed_of_any_size_stays_until_the_data_says_otherwise() -> None:
    learned = fresh_law(Bit(kinetic_torque=2e3, static_torque=3e3, stribeck_speed=15.0))
    feed(learned, np.full(200, 9.0), np.full(200, 2600.0))
    assert learned.law[3] == 15.0


def test_a_stop_that_was_lost_from_sight_is_no_stick() -> None:
    learned = fresh_law(ROCK)
    feed(learned, np.zeros(200), np.full(200, 9e3))
    lose_sight(learned)
    feed(learned, np.full(50, 8.0), torque_of(ROCK, np.full(50, 8.0)))
    assert learned.law[2] < 6100
