"""A tare: what off bottom is left of the bit's torque, parted between inertia, wall and the torque's zero."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.config import Tuning as Settings
from vsensor.estimator.tare import acceleration, correct_by_bound, correct_by_tare, weigh_bound, weigh_tare
from vsensor.estimator.tune import FRICTION, INERTIA, OFF, OFFSET, TARED, Tuning, fresh_tuning

RATE = 50.0


def test_off_bottom_the_walls_friction_is_found_once_and_no_more() -> None:
    """A wall of 5 kN·m that is in truth 30 % rougher: 1.5 kN·m are left of the bit's torque until it is."""
    tuning = fresh_tuning(Settings(), 1.0)
    for _ in range(5):
        for _ in range(500):
            wall = 5e3 * (1 + float(tuning.value[FRICTION]))
            weigh_tare(tuning, 0.0, 5e3, 6.5e3 - wall, 100.0**2, RATE)
        correct_by_tare(tuning, True)
    assert tuning.value[FRICTION] == pytest.approx(0.3, abs=0.02)
    assert tuning.variance[FRICTION] < 0.02**2


def tared(wrong: Settings, offset: float, rough: float, walls: list[float]) -> Tuning:
    """Tuned by what off bottom is left over, one wall torque after the other, of a torque read too high."""
    tuning = fresh_tuning(wrong, 1.0)
    for _ in range(8):
        for wall in walls:
            for _ in range(500):
                told = wall * (1 + float(tuning.value[FRICTION]))
                left = offset - float(tuning.value[OFFSET]) + wall * (1 + rough) - told
                weigh_tare(tuning, 0.0, wall, left, 100.0**2, RATE)
        correct_by_tare(tuning, True)
    return tuning


def test_a_torque_that_reads_too_high_is_found_where_there_is_no_wall() -> None:
    tuning = tared(Settings(torque_offset=300.0), 250.0, 0.0, [0.0])
    assert tuning.value[OFFSET] == pytest.approx(250.0, abs=10)
    assert tuning.variance[OFFSET] < 30**2
    assert tuning.value[FRICTION] == 0.0


def test_what_is_surely_right_is_not_corrected() -> None:
    tuning = tared(Settings(), 250.0, 0.0, [5e3])
    assert tuning.value[OFFSET] == 0.0
    assert tuning.variance[OFFSET] == 0.0


def test_wall_and_offset_are_parted_where_the_string_turned_both_ways() -> None:
    tuning = tared(Settings(torque_offset=500.0), 400.0, 0.2, [4e3, -4e3])
    assert tuning.value[FRICTION] == pytest.approx(0.2, abs=0.01)
    assert tuning.value[OFFSET] == pytest.approx(400.0, abs=40)


def test_turned_one_way_alone_they_share_what_is_left_by_what_each_may_be_wrong_by() -> None:
    """Their sum is known, themselves are not, and the deviations say so."""
    tuning = tared(Settings(friction=0.15, torque_offset=500.0), 400.0, 0.2, [4e3])
    left = 400.0 - tuning.value[OFFSET] + 4e3 * (0.2 - tuning.value[FRICTION])
    assert abs(left) < 60
    wall = 4e3
    together = tuning.variance[FRICTION] * wall**2 + 2 * tuning.shared[0] * wall + tuning.variance[OFFSET]
    assert 0 < together < 60**2
    assert tuning.variance[OFFSET] > 200**2


def test_inertia_and_wall_are_parted_where_the_string_speeds_up() -> None:
    """A top drive with 8 % more inertia than configured, on a wall that is a fifth rougher."""
    tuning = fresh_tuning(Settings(), 1.0)
    for _ in range(8):
        for inertial in (0.0, 4e3, 0.0, -4e3):
            for _ in range(500):
                wall = 5e3 * (1 + float(tuning.value[FRICTION]))
                left = 6e3 - wall + inertial * (0.08 - float(tuning.value[INERTIA]))
                weigh_tare(tuning, inertial, 5e3, left, 100.0**2, RATE)
        correct_by_tare(tuning, True)
    assert tuning.value[INERTIA] == pytest.approx(0.08, abs=0.005)
    assert tuning.value[FRICTION] == pytest.approx(0.2, abs=0.005)
    assert (tuning.variance[[INERTIA, FRICTION]] < 0.02**2).all()


def test_no_tare_goes_beyond_three_deviations_and_none_is_taken_up_when_switched_off() -> None:
    for enabled, most in ((True, 3 * Settings().friction), (False, 0.0)):
        tuning = fresh_tuning(Settings(), 1.0)
        for _ in range(500):
            weigh_tare(tuning, 0.0, 5e3, 5e3, 100.0**2, RATE)
        assert correct_by_tare(tuning, enabled) == enabled
        assert tuning.value[FRICTION] == pytest.approx(most)
        # It is known to be rougher than that, and the deviation says so.
        assert tuning.variance[FRICTION] ** 0.5 == pytest.approx(1.0 - most, rel=0.05)


def bounded_by(left: float, enabled: bool = True) -> Tuning:
    """Tuned by a bit that is not told to be off bottom; of its torque so much is left at the first."""
    tuning = fresh_tuning(Settings(), 1.0)
    for _ in range(5):
        for _ in range(500):
            weigh_bound(tuning, 0.0, 5e3, left - 5e3 * float(tuning.value[FRICTION]), 100.0**2, RATE)
        correct_by_tare(tuning, enabled)
        correct_by_bound(tuning, enabled)
    return tuning


def test_no_bit_drives_its_rock_so_friction_is_less_than_that() -> None:
    """A wall told a quarter too rough, of a bit off bottom that nobody told of."""
    tuning = bounded_by(-1e3)
    assert tuning.value[FRICTION] == pytest.approx(-0.2, abs=0.01)
    # It may be less rough yet, where the bit was on bottom: what is known of it has not become more.
    assert tuning.variance[FRICTION] == tuning.prior[FRICTION]
    assert tuning.value[INERTIA] == 0.0


def test_what_a_bit_takes_may_be_the_rocks_and_bounds_nothing() -> None:
    tuning = bounded_by(1e3)
    assert (tuning.value == 0.0).all()
    assert (tuning.variance == tuning.prior).all()


def test_a_bit_that_any_friction_would_have_drive_its_rock_is_misread() -> None:
    """A wall of 5 kN·m that takes nothing: friction is not wrong by so much, but the torque's reading."""
    tuning = bounded_by(-5e3)
    assert tuning.too_low[0] == 1
    assert (tuning.value == 0.0).all()
    for _ in range(1000):
        weigh_bound(tuning, 0.0, 5e3, 0.0, 100.0**2, RATE)
    correct_by_bound(tuning, True)
    assert tuning.too_low[0] == 0


def test_friction_that_may_not_be_corrected_is_the_more_doubted() -> None:
    tuning = bounded_by(-1e3, enabled=False)
    assert (tuning.value == 0.0).all()
    assert tuning.variance[FRICTION] == pytest.approx(tuning.prior[FRICTION] + 0.2**2, rel=0.02)


@given(
    st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1e3)),
    st.lists(st.tuples(*[st.floats(-1e4, 1e4)] * 3), min_size=1, max_size=5),
)
def test_what_stays_in_doubt_is_what_bayes_leaves(
    deviations: list[float], does: list[tuple[float, ...]]
) -> None:
    tuning = fresh_tuning(Settings(), 1.0)
    tuning.prior[TARED] = np.square(deviations)
    rows = np.array(does)
    tuning.information[OFF] = rows.T @ rows / 1e6
    correct_by_tare(tuning, True)
    prior = np.diag(tuning.prior[TARED])
    left = prior - prior @ rows.T @ np.linalg.solve(
        rows @ prior @ rows.T + 1e6 * np.eye(len(rows)), rows @ prior
    )
    atol = 1e-9 * float(prior.max())
    np.testing.assert_allclose(tuning.variance[TARED], np.diag(left), rtol=1e-6, atol=atol)
    np.testing.assert_allclose(tuning.shared[0], left[1, 2], rtol=1e-6, atol=atol)


@pytest.mark.parametrize("travel", [2, 40])
def test_the_acceleration_of_a_ramp_is_its_slope_however_short_the_string(travel: int) -> None:
    step_s, ring = 0.01, np.zeros(256)
    steps = np.arange(1000, 1200)
    ring[steps % 256] = 1.5 * steps * step_s
    assert acceleration(ring, 1199, travel, step_s) == pytest.approx(1.5)
