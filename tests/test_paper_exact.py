"""The closed form against methods that share nothing with it, and the kernels against the closed form."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from vsensor.estimator import component
from vsensor.paper import fine
from vsensor.paper.exact import StepResponse
from vsensor.paper.shaft import BIT, SHAFT, TORQUE, Load, of_length

LOAD = Load(2500.0, 400.0)
THETA = component.delay(SHAFT)
ZETA = component.impedance(SHAFT)
Floats = NDArray[np.float64]


def exact(load: Load = LOAD) -> StepResponse:
    return StepResponse(SHAFT, load, TORQUE)


def test_before_the_first_echo_it_is_one_exponential() -> None:
    time = np.linspace(THETA, 3 * THETA, 200)[1:-1]
    rate = (ZETA + LOAD.damping) / LOAD.inertia
    expected = 2 * TORQUE / (ZETA + LOAD.damping) * -np.expm1(-rate * (time - THETA))
    np.testing.assert_allclose(exact().end_speed(time), expected, rtol=1e-12)
    assert np.abs(exact().end_speed(np.linspace(0, THETA, 50)[:-1])).max() < 1e-12
    np.testing.assert_allclose(exact().top_speed(np.linspace(0, 2 * THETA, 50)[:-1]), TORQUE / ZETA)


@pytest.mark.parametrize(
    ("time", "speed"),
    [(3 * THETA, 8.444), (4 * THETA, 6.570), (10.0, 10.476), (20.0, 15.606)],
)
def test_numbers_known_before(time: float, speed: float) -> None:
    assert exact().end_speed([time])[0] == pytest.approx(speed, rel=1e-4)


@pytest.mark.parametrize(("delays", "speed"), [(2, 5.405), (5, 7.780)])
def test_two_more_carry_the_half_step_of_the_grid_they_came_from(delays: int, speed: float) -> None:
    """θ/2000 is such a grid: read at k h, its answers are those of (k + ½) h."""
    answer = fine.stepped(SHAFT, LOAD, TORQUE, 6 * THETA, steps=2000)
    assert round(float(answer.end.value[2000 * delays]), 3) == speed
    assert exact().end_speed([delays * THETA])[0] != pytest.approx(speed, rel=2e-4)


@pytest.mark.parametrize("load", [LOAD, BIT, Load(300.0, 900.0)])
def test_it_solves_the_delay_equation(load: Load) -> None:
    """J dω/dt = f − (ζ + D) ω with f(t) = 2T₀ − f(t − 2θ) + 2ζ ω(t − 2θ), step by step by SciPy."""
    times, speeds = by_steps(load, trips=8)
    np.testing.assert_allclose(exact(load).end_speed(times), speeds, rtol=1e-8, atol=1e-8)


def by_steps(load: Load, trips: int) -> tuple[Floats, Floats]:
    """The method of steps: time since θ in round trips, each solved with what the one before has left."""
    trip = 2 * THETA

    def arriving(since: float, before: list[tuple[float, object]]) -> float:
        """f at the end, `since` s after the first front, from the speeds of all round trips before."""
        sign, total = 1.0, 0.0
        for number in range(len(before), -1, -1):
            total += sign * 2 * TORQUE
            since -= trip
            if number == 0:
                break
            total += sign * 2 * ZETA * float(before[number - 1][1](since)[0])  # type: ignore[operator]
            sign = -sign
        return total

    before: list[tuple[float, object]] = []
    times, speeds, speed = [], [], 0.0
    for number in range(trips):
        start = number * trip

        def rate(t: float, w: Floats, known: list[tuple[float, object]] = before) -> Floats:
            return (arriving(t, known) - (ZETA + load.damping) * w) / load.inertia

        run = solve_ivp(
            rate, (start, start + trip), [speed], method="DOP853", rtol=1e-12, atol=1e-12, dense_output=True
        )
        inside = np.linspace(start, start + trip, 40)[1:-1]
        times.append(THETA + inside)
        speeds.append(run.sol(inside)[0])
        speed = float(run.y[0, -1])
        before = [*before, (start, run.sol)]
    return np.concatenate(times), np.concatenate(speeds)


@pytest.mark.parametrize("load", [LOAD, BIT])
def test_the_load_turns_by_the_torque_that_it_is_given(load: Load) -> None:
    """Eq. (19), by central differences away from the fronts."""
    time, h = (np.arange(3, 23, 2)[:, None] * THETA + np.linspace(0.1, 1.9, 12) * THETA).ravel(), 1e-4
    truth = exact(load)
    slope = (truth.end_speed(time + h) - truth.end_speed(time - h)) / (2 * h)
    turning = load.inertia * slope + load.damping * truth.end_speed(time)
    np.testing.assert_allclose(truth.end_torque(time), turning, atol=1e-3)


def test_along_the_shaft_torque_and_speed_obey_the_wave_equation() -> None:
    truth, h = exact(), 1e-4
    c, J = component.wave_speed(SHAFT), component.polar_moment(SHAFT)
    depth, dx = 1234.0, 1e-4 * c
    time = np.linspace(9 * THETA, 10 * THETA, 9)[1:-1]

    def by_time(of: str) -> Floats:
        at = getattr(truth, of)
        return np.asarray((at(depth, time + h) - at(depth, time - h)) / (2 * h))

    def by_depth(of: str) -> Floats:
        at = getattr(truth, of)
        return np.asarray((at(depth + dx, time) - at(depth - dx, time)) / (2 * dx))

    np.testing.assert_allclose(
        by_depth("torque_at"), -SHAFT.density * J * by_time("speed_at"), rtol=1e-5, atol=1e-6
    )
    np.testing.assert_allclose(
        by_depth("speed_at"), -by_time("torque_at") / (SHAFT.shear_modulus * J), rtol=1e-5, atol=1e-9
    )
    np.testing.assert_allclose(truth.torque_at(0.0, time), TORQUE)


def test_in_the_mean_it_turns_at_the_steady_speed() -> None:
    time = np.linspace(100, 200, 4001)
    assert exact().end_speed(time).mean() == pytest.approx(TORQUE / LOAD.damping, rel=1e-3)


@settings(max_examples=10)
@given(st.floats(300, 9000), st.floats(300, 5000), st.floats(10, 2000))
def test_the_kernels_come_to_the_closed_form(length: float, inertia: float, damping: float) -> None:
    """Two grids, extrapolated: to 1e-6, fronts and all, for any shaft and load."""
    shaft, load = of_length(length), Load(inertia, damping)
    theta = component.delay(shaft)
    rate = (component.impedance(shaft) + damping) / inertia
    steps = math.ceil(theta * max(100.0, 50 * rate))  # fifty in the load's own time
    answer = fine.refined(shaft, load, TORQUE, 12 * theta, steps)
    truth = StepResponse(shaft, load, TORQUE)
    steady = TORQUE / damping
    scale = max(steady, TORQUE / component.impedance(shaft))
    for trace, expected, size in (
        (answer.top, truth.top_speed, scale),
        (answer.end, truth.end_speed, scale),
        (answer.end_torque, truth.end_torque, TORQUE),
    ):
        np.testing.assert_allclose(trace.value, expected(trace.time), atol=1e-6 * size)


def test_a_single_grid_is_nearer_by_the_square_of_its_step() -> None:
    truth = exact(BIT)
    errors = []
    for steps in (200, 400, 800, 1600):
        answer = fine.stepped(SHAFT, BIT, TORQUE, 20.0, steps)
        errors.append(np.abs(answer.end.value - truth.end_speed(answer.end.time)).max())
    np.testing.assert_allclose(np.array(errors[:-1]) / np.array(errors[1:]), 4, rtol=0.05)
    assert errors[-1] < 1e-6 * 17.5


def test_the_papers_length_to_a_millionth_in_ten_minutes_of_ringing() -> None:
    answer = fine.refined(SHAFT, LOAD, TORQUE, 600.0, steps=500)
    few = slice(0, None, 997)
    time = answer.end.time[few]
    np.testing.assert_allclose(answer.end.value[few], exact().end_speed(time), atol=1e-6 * 17.5)
