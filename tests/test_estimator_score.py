"""Scores, each against what made its data."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.observer import LINEAR
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.score import NOW, REST, SPEED, expect, foretell, fresh_scores, missed, score
from vsensor.estimator.sections import Floats
from vsensor.estimator.tune import FRICTION, fresh_tuning, wall_torque

RATE = 50.0


TURNS = 10.0
"""rad/s, a bit that turns."""


def scored(changes: Floats, u: Floats, a: float, b: float, seed: int = 1) -> Floats:
    """The law found from normal misses whose variance is a u + b x²."""
    random = np.random.default_rng(seed)
    scores = fresh_scores(4, RATE)
    for tick, (x, expected) in enumerate(zip(changes, u, strict=True)):
        scores.foretold[NOW, SPEED, :, tick % 4] = TURNS, x, expected
        miss = np.sqrt(a * expected + b * x * x) * random.standard_normal()
        score(scores, NOW, SPEED, tick, TURNS + float(miss), RATE)
    return np.asarray(scores.law[NOW, SPEED])


@pytest.mark.parametrize(("a", "b"), [(1.0, 4.0), (3.0, 0.5), (0.5, 20.0)])
def test_what_misses_are_made_of_is_found(a: float, b: float) -> None:
    random = np.random.default_rng(2)
    law = scored(np.abs(random.standard_normal(20_000)), random.uniform(0.05, 0.2, 20_000), a, b)
    assert law == pytest.approx([a, b], rel=0.25)


def test_where_changes_tell_nothing_the_gains_variance_alone_is_scaled() -> None:
    law = scored(np.zeros(20_000), np.full(20_000, 0.1), 2.5, 0.0)
    assert law == pytest.approx([2.5, 0.0], rel=0.1)


def test_before_anything_was_scored_it_is_as_the_gains_have_it_and_is_not_told() -> None:
    scores = fresh_scores(4, RATE)
    assert (scores.law == [1.0, 0.0]).all()
    expect(scores, NOW, 0, np.array([0.3, 0.3]), True)
    foretell(scores, NOW, SPEED, 0, TURNS, 7.0)
    assert math.isnan(missed(scores, NOW, SPEED, 0))
    scores.scored[NOW] = 1
    expect(scores, NOW, 1, np.array([0.3, 0.3]), True)
    foretell(scores, NOW, SPEED, 1, TURNS, 7.0)
    assert missed(scores, NOW, SPEED, 1) == 0.3


def test_a_bit_foretold_to_rest_has_misses_of_its_own() -> None:
    """Half of the time it rests, and does: of a bit that turns that says nothing."""
    random = np.random.default_rng(3)
    scores = fresh_scores(4, RATE)
    scores.scored[NOW] = 1
    for tick in range(20_000):
        rests = tick // 50 % 2 == 0
        expect(scores, NOW, tick, np.array([0.1, 1e4]), True)
        foretell(scores, NOW, SPEED, tick, 0.0 if rests else TURNS, 0.0)
        truth = 0.0 if rests else TURNS + np.sqrt(0.2) * random.standard_normal()
        score(scores, NOW, SPEED, tick, float(truth), RATE)
    assert scores.law[NOW, SPEED] == pytest.approx([2.0, 0.0], rel=0.1)
    assert scores.law[NOW, REST, 0] < 0.02
    for speed, law in ((TURNS, SPEED), (0.0, REST)):
        expect(scores, NOW, 0, np.array([0.1, 1e4]), True)
        foretell(scores, NOW, SPEED, 0, speed, 0.0)
        assert missed(scores, NOW, SPEED, 0) == pytest.approx(0.1 * scores.law[NOW, law, 0])


def test_a_wild_miss_is_no_more_than_one_of_five_deviations() -> None:
    one, other = fresh_scores(4, RATE), fresh_scores(4, RATE)
    for scores, miss in ((one, 1e9), (other, 5.0 * np.sqrt(0.1))):
        scores.foretold[NOW, SPEED, :, 0] = TURNS, 0.0, 0.1
        score(scores, NOW, SPEED, 0, TURNS + miss, RATE)
    assert one.law[NOW, SPEED] == pytest.approx(other.law[NOW, SPEED])
    assert one.law[NOW, SPEED, 0] > 1


@settings(max_examples=30)
@given(
    st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(0, 1e3), st.floats(1e-6, 1e3)), max_size=60),
    st.sampled_from([0.0, TURNS]),
)
def test_no_variance_is_ever_negative_or_unknown(misses: list[tuple[float, float, float]], w: float) -> None:
    scores = fresh_scores(4, RATE)
    for tick, (miss, change, expected) in enumerate(misses):
        scores.foretold[NOW, SPEED, :, tick % 4] = w, change, expected
        score(scores, NOW, SPEED, tick, w + miss, RATE)
    assert np.isfinite(scores.law).all()
    assert (scores.law >= 0).all()


@pytest.fixture(scope="module")
def linear() -> Estimator:
    return Estimator(LINEAR)


def test_the_walls_torque_is_that_of_all_junctions_and_against_the_motion(linear: Estimator) -> None:
    line = linear.line
    line = line._replace(kinetic=np.full_like(line.kinetic, 10.0))
    viscous, count = float(line.viscous.sum()), len(line.kinetic)
    tuning = fresh_tuning(LINEAR.tuning, 1.0)
    assert wall_torque(line, tuning, 3.0) == pytest.approx(3 * viscous + 10 * count)
    assert wall_torque(line, tuning, -3.0) == pytest.approx(-3 * viscous - 10 * count)
    assert wall_torque(line, tuning, 0.0) == 0.0
    tuning.value[FRICTION] = 0.25  # the line is the corrected one, and the torque that of the configured
    assert wall_torque(line, tuning, 3.0) == pytest.approx((3 * viscous + 10 * count) / 1.25)
