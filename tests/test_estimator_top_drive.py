"""The smoother: no phase, a stated band, exact for what is slow."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.config import TopDrive
from vsensor.estimator.sections import Floats
from vsensor.estimator.top_drive import (
    Smoother,
    half_width,
    smoother,
    string_speed,
    string_torque,
    turning_torque,
)

RATE, STEPS, BAND = 100.0, 4, 3.0
HALF = half_width(BAND, RATE)
NOW = np.arange(-2 * HALF, 1) / RATE
BARE = TopDrive()


def string_top(weights: Smoother, row: int, torque: Floats, speed: Floats) -> tuple[float, float]:
    t = string_torque(weights, row, torque) - turning_torque(weights, row, speed)
    return t, string_speed(weights, row, speed)


def when(row: int) -> float:
    """The time that a row of the smoother answers for, the newest sample being at 0."""
    return -(HALF + (STEPS - 1 - row) / STEPS) / RATE


@given(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), st.integers(0, STEPS - 1))
def test_constants_and_ramps_pass_exactly_at_every_internal_step(
    level: float, slope: float, row: int
) -> None:
    weights = smoother(BARE, BAND, RATE, STEPS)
    ramp = level + slope * NOW
    torque, speed = string_top(weights, row, ramp, ramp)
    expected = level + slope * when(row)
    assert torque == pytest.approx(expected, rel=1e-9, abs=1e-6)
    assert speed == pytest.approx(expected, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("frequency", [0.5, 1.5, 3.0, 6.0, 10.0])
def test_the_response_is_that_of_the_smoothing_spline_without_phase(frequency: float) -> None:
    """1 / (1 + (f/f_c)⁴), Silverman (1984)."""
    weights = smoother(BARE, BAND, RATE, STEPS)
    wave = np.exp(2j * np.pi * frequency * NOW)
    for row in range(STEPS):
        answer = weights.speed_of_speed[row] @ wave * np.exp(-2j * np.pi * frequency * when(row))
        assert answer.real == pytest.approx(1 / (1 + (frequency / BAND) ** 4), abs=0.01)
        assert answer.imag == pytest.approx(0, abs=0.015)


def test_the_inertia_of_the_top_drive_is_taken_off() -> None:
    drive = TopDrive(inertia=2000, gear_ratio=8.0, efficiency=0.9)
    weights = smoother(drive, BAND, RATE, STEPS)
    motor_speed = 8 * (3 + 0.5 * NOW)
    torque, speed = string_top(weights, STEPS - 1, np.full_like(NOW, 1000.0), motor_speed)
    assert torque == pytest.approx(8 * 0.9 * 1000 - 2000 * 0.5, rel=1e-9)
    assert speed == pytest.approx(3 + 0.5 * when(STEPS - 1), rel=1e-9)


def test_the_converters_lag_is_undone() -> None:
    drive = TopDrive(torque_lag=0.02)
    weights = smoother(drive, BAND, RATE, STEPS)
    late = 100 * (NOW - 0.02)
    torque, _ = string_top(weights, 0, late, np.zeros_like(NOW))
    assert torque == pytest.approx(100 * when(0), rel=1e-9)
