"""The top drive smoothed: no phase, a stated band, and as little noise as the samples allow."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.config import Measurement, TopDrive
from vsensor.estimator.sections import Floats
from vsensor.estimator.top_drive import (
    Smoother,
    Smoothers,
    smoothers,
    speed_alone,
    string_speed,
    string_torque,
    turning_torque,
)

RATE, STEPS, BAND = 100.0, 4, 3.0
NOISE = Measurement()
HEAVY = TopDrive(inertia=2000)
BARE = TopDrive()


def made(drive: TopDrive) -> tuple[Smoothers, Floats]:
    """The weights for a drive, and the times of the window's samples, the newest at 0."""
    smooth = smoothers(drive, NOISE, BAND, RATE, STEPS)
    width = smooth.confirmed.speed_of_speed.shape[1]
    return smooth, np.arange(1 - width, 1) / RATE


def top(smooth: Smoother, row: int, torque: Floats, speed: Floats) -> tuple[float, float]:
    t = string_torque(smooth, row, torque) - turning_torque(smooth, row, speed)
    return t, string_speed(smooth, row, torque, speed)


def when(smooth: Smoothers, row: int) -> float:
    """The time that a confirmed row answers for."""
    return -(smooth.lag + (STEPS - 1 - row) / STEPS) / RATE


@pytest.mark.parametrize("drive", [HEAVY, BARE])
@given(level=st.floats(-1e4, 1e4), row=st.integers(0, STEPS - 1))
def test_steady_torque_and_speed_pass_unchanged(drive: TopDrive, level: float, row: int) -> None:
    smooth, now = made(drive)
    for rows, row_ in ((smooth.confirmed, row), (smooth.provisional, row)):
        torque, speed = top(rows, row_, np.full_like(now, level), np.full_like(now, level / 1e3))
        assert torque == pytest.approx(level, rel=1e-4, abs=0.5)
        assert speed == pytest.approx(level / 1e3, rel=1e-4, abs=1e-5)


def test_the_inertia_of_the_top_drive_is_taken_off() -> None:
    smooth, now = made(TopDrive(inertia=2000, gear_ratio=8.0, efficiency=0.9))
    motor_speed = 8 * (3 + 0.5 * now)
    torque, speed = top(smooth.confirmed, STEPS - 1, np.full_like(now, 1000.0), motor_speed)
    assert torque == pytest.approx(8 * 0.9 * 1000 - 2000 * 0.5, rel=1e-3)
    assert speed == pytest.approx(3 + 0.5 * when(smooth, STEPS - 1), rel=1e-3)


@pytest.mark.parametrize("frequency", [0.5, 1.5, 3.0, 6.0])
def test_the_response_falls_past_the_band_and_has_no_phase(frequency: float) -> None:
    """1 / (1 + (f/f_c)⁴) of a string torque that truly turns the drive, with the lag cut short."""
    smooth, now = made(HEAVY)
    wave = np.exp(2j * np.pi * frequency * now)
    speed = -wave / (2j * np.pi * frequency * HEAVY.inertia)  # the motor adds nothing
    for row in range(STEPS):
        answer = -(smooth.confirmed.torque_of_speed[row] @ speed) * -1
        answer *= np.exp(-2j * np.pi * frequency * when(smooth, row))
        assert answer.real == pytest.approx(1 / (1 + (frequency / BAND) ** 4), abs=0.04)
        assert answer.imag == pytest.approx(0, abs=0.06)


def test_the_confirmed_answer_is_the_least_noisy_and_the_newest_the_noisiest() -> None:
    smooth, _ = made(HEAVY)

    def noise(rows: Smoother, row: int) -> float:
        of_torque = NOISE.torque_noise**2 * np.sum(rows.torque_of_torque[row] ** 2)
        return float(np.sqrt(of_torque + NOISE.speed_noise**2 * np.sum(rows.torque_of_speed[row] ** 2)))

    later = [noise(smooth.provisional, row) for row in range(len(smooth.provisional.torque_of_torque))]
    assert noise(smooth.confirmed, STEPS - 1) < min(later) * 1.05
    assert max(later) == later[-1] < 3 * noise(smooth.confirmed, STEPS - 1)


def test_no_weighting_of_the_samples_does_better_at_following_a_random_torque() -> None:
    """A Kalman smoother is the best linear one for its own model: any change of its weights costs."""
    random = np.random.default_rng(3)
    smooth, now = made(HEAVY)
    width, n = len(now), 40_000
    omega = 2 * np.pi * BAND
    strength = (NOISE.torque_noise**2 + (2000 * omega * NOISE.speed_noise) ** 2) / RATE * omega**2
    fine = 8
    pull = np.cumsum(random.standard_normal(n * fine)) * np.sqrt(strength / RATE / fine)
    pull -= np.linspace(0, pull[-1], len(pull))
    speed = -np.cumsum(pull) / (RATE * fine) / 2000
    told = speed[::fine] + NOISE.speed_noise * random.standard_normal(n)
    motor = NOISE.torque_noise * random.standard_normal(n)
    windows = np.lib.stride_tricks.sliding_window_view
    truth = pull[::fine][width - 1 - smooth.lag : n - smooth.lag]
    both = np.hstack([windows(motor, width), windows(told, width)])
    rows = smooth.confirmed
    weights = np.concatenate([rows.torque_of_torque[-1], rows.torque_of_speed[-1]])

    def error(w: Floats) -> float:
        return float(np.mean((both @ w - truth) ** 2))

    best = error(weights)
    for kick in random.standard_normal((10, 2 * width)):
        assert error(weights + 0.1 * np.abs(weights) * kick) > best


def test_a_late_converter_is_brought_forward() -> None:
    smooth, now = made(TopDrive(torque_lag=0.02))
    late = 100 * (now - 0.02)
    torque, _ = top(smooth.confirmed, STEPS - 1, late, np.zeros_like(now))
    punctual, unmoved = made(BARE)
    expected, _ = top(punctual.confirmed, STEPS - 1, 100 * unmoved, np.zeros_like(unmoved))
    assert torque == pytest.approx(expected, rel=0.01)


def test_speed_alone_serves_where_torque_is_lost() -> None:
    smooth, now = made(HEAVY)
    assert speed_alone(smooth.confirmed, 0, np.full_like(now, 7.0)) == pytest.approx(7.0, rel=1e-3)
