"""The ratio of two clocks is told from what both have recorded, whatever lies between them."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.clocks import clock_rate, period, set_right

TIME = np.arange(0.0, 60.0, 0.02)


def swinging(time: NDArray[np.float64], seconds: float, late_s: float = 0.0) -> NDArray[np.float64]:
    """Stick-slip in little: a pulse a period, on a drifting mean."""
    return np.asarray(np.exp(3 * np.cos(2 * np.pi * (time - late_s) / seconds)) + 0.02 * time)


@pytest.mark.parametrize("seconds", [3.6, 3.912, 4.4])
def test_the_period_is_told_to_a_millisecond(seconds: float) -> None:
    assert period(TIME, swinging(TIME, seconds)) == pytest.approx(seconds, abs=1.5e-3)


@pytest.mark.parametrize("rate", [0.99, 1.0, 1.007])
def test_a_clock_that_runs_at_another_rate_is_found_and_set_right(rate: float) -> None:
    heard = TIME[::25]
    bit = swinging(30 + rate * (heard - 30), 3.9, late_s=0.7)
    surface = {"time_s": TIME, "motor_torque_nm": 1e3 * swinging(TIME, 3.9)}
    truth = {"time_s": heard, "bit_speed_min_rad_s": bit - 1, "bit_speed_max_rad_s": bit + 1}
    found = clock_rate(surface, truth)
    assert found == pytest.approx(rate, abs=1e-3)
    right = set_right(truth, found)
    assert clock_rate(surface, right) == pytest.approx(1.0, abs=1e-3)
    assert right["bit_speed_min_rad_s"] is truth["bit_speed_min_rad_s"]
