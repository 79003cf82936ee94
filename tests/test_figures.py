"""Period, stuck share, turning back and power over a window, on signals that are known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.estimator.figures import ROWS, STUCK_SPEED, Figures, figures, period
from vsensor.estimator.sections import Floats

TICK = 0.01
TIME = np.arange(2000) * TICK


def window(
    bit: Floats | float, torque: Floats | float = 3e3, top: Floats | float = 10.0, top_torque: float = 5e3
) -> Floats:
    """Twenty seconds."""
    rows = [np.broadcast_to(row, TIME.shape) for row in (bit, torque, top, top_torque)]
    return np.array(rows, dtype=np.float64)


def stick_slip(seconds: float) -> Floats:
    """A bit that stands for half of each period and swings up to 20 rad/s in the other."""
    return np.asarray(np.maximum(0.0, 20 * np.sin(2 * math.pi * TIME / seconds)))


@given(st.floats(0.5, 6.0), st.floats(0.1, 50.0), st.floats(-30.0, 30.0))
def test_the_period_of_a_swing_whatever_its_size_and_mean(seconds: float, size: float, mean: float) -> None:
    swing = mean + size * np.sin(2 * math.pi * TIME / seconds)
    assert period(swing, TICK) == pytest.approx(seconds, abs=TICK)


@pytest.mark.parametrize("seconds", [1.0, 3.3, 5.17, 9.5])
def test_the_period_of_stick_slip_is_found_under_noise_and_a_second_mode(seconds: float) -> None:
    random = np.random.default_rng(1)
    noisy = stick_slip(seconds) + np.sin(2 * math.pi * TIME / 0.7) + 0.2 * random.standard_normal(len(TIME))
    assert period(noisy, TICK) == pytest.approx(seconds, rel=0.03)


@pytest.mark.parametrize(
    "speeds",
    [
        np.array([]),
        np.full(2000, math.nan),
        np.full(2000, 10.0),
        stick_slip(15.0),
        np.sin(TIME**2),
    ],
    ids=["empty", "unknown", "steady", "too slow for the window", "ever faster"],
)
def test_what_is_not_periodic_has_no_period(speeds: Floats) -> None:
    assert math.isnan(period(speeds, TICK))


def test_noise_has_no_period() -> None:
    random = np.random.default_rng(2)
    band = np.convolve(random.standard_normal(2100), np.ones(30) / 30, "valid")[:2000]
    assert math.isnan(period(10 + band, TICK))


@given(st.integers(0, 1999), st.integers(0, 20))
def test_a_few_unknown_ticks_do_not_change_the_period(at: int, count: int) -> None:
    holed = stick_slip(4.0)
    holed[at : at + count] = math.nan
    assert period(holed, TICK) == pytest.approx(4.0, abs=0.1)


def test_the_bit_is_stuck_while_it_stands_and_the_top_turns() -> None:
    stands = np.where(TIME < 5, 0.9 * STUCK_SPEED, 8.0)
    assert figures(window(stands), TICK).stuck_share == 0.25
    assert figures(window(-stands), TICK).stuck_share == 0.25
    turns = np.where(TIME < 2, 0.9 * 2 * STUCK_SPEED, 10.0)
    assert figures(window(stands, top=turns), TICK).stuck_share == pytest.approx(0.15)
    assert figures(window(0.0, top=0.0), TICK).stuck_share == 0


@pytest.mark.parametrize("direction", [1, -1])
def test_turning_back_is_against_the_top_whichever_way_it_turns(direction: int) -> None:
    bit = direction * np.where(TIME < 2, -math.pi, 10.0)
    told = figures(window(bit, top=direction * 10.0), TICK)
    assert told.back_rotation_share == pytest.approx(0.1)
    assert told.back_rotation_turns == pytest.approx(1.0)


def test_noise_about_a_standstill_is_no_turning_back_nor_is_rocking_under_a_top_at_rest() -> None:
    creeping = np.where(TIME < 2, -0.9 * STUCK_SPEED, 10.0)
    assert figures(window(creeping), TICK).back_rotation_turns == 0
    assert figures(window(5 * np.sin(TIME), top=0.0), TICK).back_rotation_share == 0


def test_power_is_fed_in_at_the_top_and_what_does_not_come_down_is_lost() -> None:
    told = figures(window(10.0, torque=3e3, top=10.0, top_torque=5e3), TICK)
    assert (told.top_power_w, told.bit_power_w, told.lost_power_w) == (50e3, 30e3, 20e3)


def test_the_mean_power_is_that_of_the_products() -> None:
    swing = np.sin(2 * math.pi * TIME / 5)
    told = figures(window(10 + 4 * swing, torque=3e3 - 1e3 * swing), TICK)
    assert told.bit_power_w == pytest.approx(30e3 - 2e3, rel=1e-3)


@given(st.lists(st.tuples(st.integers(0, ROWS - 1), st.integers(0, 1999)), max_size=30))
def test_ticks_of_which_not_all_is_known_do_not_count(holes: list[tuple[int, int]]) -> None:
    holed = window(np.where(TIME < 10, 6.0, 10.0))
    for row, tick in holes:
        holed[row, tick] = math.nan
    known = holed[:, np.isfinite(holed).all(axis=0)]
    told = figures(holed, TICK)
    assert told.bit_power_w == pytest.approx(float(np.mean(known[0] * known[1])))
    assert told.stuck_share == 0


def test_of_an_unknown_window_nothing_is_told() -> None:
    told = figures(np.full((ROWS, 100), math.nan), TICK)
    assert len(told) == len(Figures._fields)
    assert all(math.isnan(value) for value in told)
