"""The waves in the string: kernels against their twins, closed forms, and the laws of physics."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests import naive
from tests.peel import peeled
from tests.strings import COLLAR, PIPE, strings
from vsensor.config import Bit, Component, TopDrive
from vsensor.estimator.forward import Controller, ForwardLine
from vsensor.estimator.line import FADE_SPEED
from vsensor.estimator.load import Foot, load_of, turn_bit
from vsensor.estimator.sections import cut
from vsensor.jit import COMPILED

STEP = 5e-3
SEEDS = st.integers(0, 2**32 - 1)


@settings(max_examples=30)
@given(strings(), SEEDS)
def test_peeling_is_its_naive_twin(string: tuple[Component, ...], seed: int) -> None:
    random = np.random.default_rng(seed)
    line = cut(string, STEP, 300)
    torques, speeds = 5e3 * random.standard_normal(80), 5 * random.standard_normal(80)
    expected = np.array(naive.descend(line, torques.tolist(), speeds.tolist()), dtype=np.float64)
    np.testing.assert_allclose(peeled(line, torques, speeds), expected, rtol=1e-9, atol=1e-6)


@settings(max_examples=20)
@given(strings(most=4), SEEDS)
def test_the_march_is_its_naive_twin(string: tuple[Component, ...], seed: int) -> None:
    random = np.random.default_rng(seed)
    line = cut(string, STEP, 300)
    bit = Bit(inertia=60, viscous_friction=4, kinetic_torque=2e3, static_torque=4e3, stribeck_speed=1.2)
    torques = 4e3 + 6e3 * random.standard_normal(120)
    forward = ForwardLine(line, TopDrive(inertia=900), bit, STEP)
    twin = naive.Forward(line, load_of(bit, STEP), 2 * 900 / STEP)
    expected = np.array([twin.step(t) for t in torques]).T
    np.testing.assert_allclose(forward.run(torques, np.zeros(120)), expected, rtol=1e-6, atol=1e-6)


def test_a_speed_controller_is_its_naive_twin_and_keeps_its_limit() -> None:
    line = cut((PIPE, COLLAR), STEP, 300)
    drive = TopDrive(inertia=900, gear_ratio=2.0, efficiency=0.9)
    bit = Bit(inertia=60, viscous_friction=40)
    by = Controller(2e3, 20.0, 4e3)
    targets = np.where(np.arange(400) < 200, 4.0, -1.0)
    told = ForwardLine(line, drive, bit, STEP).control(by, targets, np.zeros(400))
    twin, integral, speed = ForwardLine(line, drive, bit, STEP), 0.0, 0.0
    for k, target in enumerate(targets):
        wanted = by.gain * (target - speed) + integral
        given = min(max(wanted, -by.limit), by.limit)
        if given == wanted:
            integral += by.integral_rate * (target - speed)
        expected = (given / 1.8, *(each[0] for each in twin.run([given / 1.8], [0.0])))
        assert [each[k] for each in told] == pytest.approx(expected, rel=1e-9, abs=1e-9)
        speed = expected[1] / 2.0
    held = np.abs(told[0]) * 1.8
    assert held.max() == pytest.approx(by.limit)
    assert 0.05 < np.mean(np.isclose(held, by.limit)) < 0.95


@settings(max_examples=20)
@given(strings(friction=False), SEEDS)
def test_peeling_undoes_the_march(string: tuple[Component, ...], seed: int) -> None:
    """What torque and speed at the top tell of the bit is what was true there: an independent truth."""
    random = np.random.default_rng(seed)
    line = cut(string, STEP, 300)
    bit = Bit(inertia=50, viscous_friction=20)
    torques = np.cumsum(random.standard_normal(200)) * 300
    forward = ForwardLine(line, TopDrive(), bit, STEP)
    top, bit_speed, bit_torque = forward.run(torques, np.zeros(200))
    bottom = peeled(line, torques, top)
    scale = np.abs(bit_speed).max() + 1e-3
    np.testing.assert_allclose(bottom[:, 1], bit_speed, atol=1e-7 * scale)
    settled = bottom[1:, 0] - 50 * np.diff(bit_speed) / STEP
    # The load's torque, but for half a step of the bit's inertia.
    np.testing.assert_allclose(
        np.cumsum(settled), np.cumsum(bit_torque[1:]), atol=np.abs(bottom[:, 0]).max() + 1
    )


def test_wall_friction_is_taken_off_where_it_acts() -> None:
    rough = PIPE.model_copy(update={"coulomb_friction": 2.0, "static_friction": 2.0})
    line = cut((rough, COLLAR), STEP, 200)
    forward = ForwardLine(line, TopDrive(), Bit(inertia=50, viscous_friction=400), STEP)
    torques = np.full(20_000, 9e3)
    top, bit_speed, _ = forward.run(torques, np.zeros(20_000))
    bottom = peeled(line, torques, top)
    turning = slice(2000, None)
    assert bit_speed[turning].min() > FADE_SPEED
    np.testing.assert_allclose(bottom[turning, 1], bit_speed[turning], rtol=1e-6)
    assert bottom[-1, 0] == pytest.approx(9e3 - 1500 * 2.0 - 1500 * 0.02 * bit_speed[-1], rel=1e-3)


@settings(max_examples=30)
@given(strings(), SEEDS, st.floats(0, 500), st.floats(0, 5e3))
def test_the_string_is_passive(
    string: tuple[Component, ...], seed: int, viscous: float, kinetic: float
) -> None:
    """The power stored in the waves never grows by more than what the top puts in."""
    random = np.random.default_rng(seed)
    line = cut(string, STEP, 300)
    bit = Bit(viscous_friction=viscous, kinetic_torque=kinetic, static_torque=kinetic)
    forward = ForwardLine(line, TopDrive(), bit, STEP)
    torques = 8e3 * random.standard_normal(150)
    twin = naive.Forward(line, load_of(bit, STEP), 0.0)

    def stored() -> float:
        waves = zip(twin.queues, line.impedance.tolist(), strict=True)
        return float(sum(sum(f * f for f in queue) / z for queue, z in waves))

    before = stored()
    for torque in torques:
        top, bit_speed, _ = twin.step(torque)
        fed = 4 * torque * top
        after = stored()
        assert after - before <= fed + 1e-6 * (abs(fed) + after + 1)
        before = after
        assert forward.run([torque], [0.0])[1][0] == pytest.approx(bit_speed, rel=1e-6, abs=1e-6)


@pytest.mark.skipif(not COMPILED, reason="a long record: too slow without the compiler")
def test_the_papers_step_against_its_closed_form() -> None:
    """ω₁ = 0 until θ, then (2T₀/(ζ+D)) (1 − exp(−(ζ+D)(t−θ)/J)) until 3θ; steady at T₀/D."""
    pipe = Component(
        length=4000, outer_diameter=0.1682, inner_diameter=0.149884, shear_modulus=79.6e9, density=8009
    )
    theta, zeta, damping, inertia, torque = 1.2687976, 733.009, 400.0, 2500.0, 7000.0
    step = theta / 1000
    line = cut((pipe,), step, 5000)
    forward = ForwardLine(line, TopDrive(), Bit(inertia=inertia, viscous_friction=damping), step)
    n = 300_000
    top, bit_speed, _ = forward.run(np.full(n, torque), np.zeros(n))
    time = np.arange(n) * step - forward.bit_delay
    assert top[0] == pytest.approx(torque / zeta, rel=1e-6)
    assert bit_speed[time < theta - step].max() == 0
    rising = (time > theta + step) & (time < 3 * theta - step)
    rate = (zeta + damping) / inertia
    exact = 2 * torque / (zeta + damping) * -np.expm1(-rate * (time[rising] - theta))
    # A step begins half a step into its first one.
    np.testing.assert_allclose(bit_speed[rising], exact, atol=torque / inertia * step * 1.1)
    for at, expected in (
        (2 * theta, 5.405),
        (4 * theta, 6.570),
        (5 * theta, 7.780),
        (10, 10.476),
        (20, 15.606),
    ):
        assert np.interp(at, time, bit_speed) == pytest.approx(expected, abs=0.005)
    # The inertia keeps the short waves in: they ring on for minutes, about the steady speed.
    assert bit_speed[-200_000:].mean() == pytest.approx(torque / damping, rel=1e-3)


def test_the_bit_sticks_until_its_static_torque_is_passed() -> None:
    bit = Bit(inertia=10, kinetic_torque=1e3, static_torque=3e3, stribeck_speed=1.0)
    line = cut((COLLAR,), STEP, 300)
    forward = ForwardLine(line, TopDrive(), bit, STEP)
    held = forward.run(np.full(2000, 2.9e3), np.zeros(2000))[1]
    # A wave doubles at a bit that holds: 2.9 kN·m sent down arrives as up to 5.8, and breaks it loose.
    assert held.max() > 0
    forward = ForwardLine(line, TopDrive(), bit, STEP)
    slow = np.minimum(np.arange(4000) * 1.0, 2.9e3)
    assert forward.run(slow, np.zeros(4000))[1].max() == 0
    assert forward.run(np.full(2000, 3.2e3), np.zeros(2000))[1].max() > 1


def test_a_sliding_bit_without_inertia_keeps_to_the_fast_branch_of_its_law() -> None:
    """Where the law falls faster than the impedance holds, two speeds and rest balance one wave."""
    load = load_of(Bit(kinetic_torque=1e3, static_torque=4e3, stribeck_speed=0.5), STEP)
    foot = Foot(impedance=600.0, viscous=0.0, kinetic=0.0, static=0.0)
    assert turn_bit(load, foot, 2.6e3, 0.0, 0.0) == (0.0, 0.0)
    speed, _ = turn_bit(load, foot, 2.6e3, 3.0, 0.0)
    assert speed > math.log(10) / 2  # right of the least torque of the two together
    assert 600 * speed + naive.law(load, speed) == pytest.approx(2.6e3, rel=1e-9)
    assert turn_bit(load, foot, 1.9e3, 3.0, 0.0) == (0.0, 0.0)
