"""Stick-slip severity: (max − min) / (2 mean) of the bit's speed."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.estimator.sections import Floats
from vsensor.estimator.severity import severity

speeds = st.lists(st.floats(0.2, 50.0), min_size=1, max_size=30).map(np.array)


def wave(mean: float, amplitude: float) -> Floats:
    return np.asarray(mean + amplitude * np.sin(np.linspace(0, 20 * math.pi, 2001)))


@pytest.mark.parametrize(
    ("mean", "amplitude", "expected"), [(10, 0, 0), (10, 5, 0.5), (10, 10, 1), (4, 6, 1.5)]
)
def test_a_swing_about_a_mean(mean: float, amplitude: float, expected: float) -> None:
    assert severity(wave(mean, amplitude)) == pytest.approx(expected, abs=1e-3)


def test_a_bit_that_just_stops_in_each_period_has_1_and_one_that_sticks_longer_has_more() -> None:
    swing = wave(8, 8)
    assert severity(swing) == pytest.approx(1, abs=1e-3)
    assert severity(np.where(swing < 8, 0, swing)) > 1.2


@given(speeds, st.floats(1.0, 100.0))
def test_it_is_a_pure_number(window: Floats, factor: float) -> None:
    assert severity(factor * window) == pytest.approx(severity(window))


@given(speeds)
def test_the_direction_of_turning_does_not_matter(window: Floats) -> None:
    assert severity(-window) == severity(window)


@given(speeds, st.integers(1, 20), st.randoms(use_true_random=False))
def test_ticks_without_an_answer_do_not_count(window: Floats, unknown: int, random: object) -> None:
    holed = [*window, *[math.nan] * unknown]
    random.shuffle(holed)  # type: ignore[attr-defined]
    assert severity(np.array(holed)) == pytest.approx(severity(window))


@pytest.mark.parametrize(
    "window",
    [[], [math.nan] * 5, [0.0] * 5, [0.09, -0.02], [-5.0, 5.0]],
    ids=["empty", "unknown", "at rest", "creeping", "rocking"],
)
def test_a_bit_that_does_not_turn_on_the_whole_has_none(window: list[float]) -> None:
    assert math.isnan(severity(np.array(window)))
