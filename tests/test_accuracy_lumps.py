"""The two-lump yardstick on a rig that is two lumps and a spring."""

import numpy as np
import pytest

from tests.accuracy.lumps import BIT_SPEED, BIT_TORQUE, Filter, Lumps, Tuning, told, watched
from tests.accuracy.score import Floats, score
from tests.strings import COLLAR, DRIVE, PIPE, rig
from vsensor.estimator import component

STEP, FINE = 0.01, 20
TORQUE_NOISE, SPEED_NOISE, WALK = 80.0, 0.015, 1e5
LUMPS = Lumps(top_inertia=2500.0, bit_inertia=600.0, stiffness=500.0, viscous=30.0, coulomb=400.0)


def simulated(seconds: float, seed: int) -> tuple[Floats, Floats, dict[str, Floats]]:
    """Motor torque and speed as measured, and what is true at the bit, by small semi-implicit steps."""
    random = np.random.default_rng(seed)
    count, h = round(seconds / STEP), STEP / FINE
    walk = np.cumsum(random.normal(0, np.sqrt(WALK * STEP), count)) + 2e3
    motor: Floats = 5e3 + 1e3 * np.sin(0.8 * np.linspace(0.0, seconds, count, endpoint=False))
    top, bit, twist = 8.0, 8.0, 7.0
    seen = np.empty((count, 2))
    for n in range(count):
        seen[n] = top, bit
        for _ in range(FINE):
            twist += h * (top - bit)
            pull = LUMPS.stiffness * twist
            top += h * (motor[n] - pull - _rubbing(top)) / LUMPS.top_inertia
            bit += h * (pull - _rubbing(bit) - walk[n]) / LUMPS.bit_inertia
    time = np.linspace(0.0, seconds, count, endpoint=False)
    truth = {"time_s": time, "bit_speed_rad_s": seen[:, 1], "bit_torque_nm": walk}
    noisy = motor + random.normal(0, TORQUE_NOISE, count)
    return noisy, seen[:, 0] + random.normal(0, SPEED_NOISE, count), truth


def _rubbing(speed: float) -> float:
    return LUMPS.viscous * speed + float(np.sign(speed)) * LUMPS.coulomb


def filtering(walk: float = WALK) -> Filter:
    return Filter(LUMPS, STEP, TORQUE_NOISE, SPEED_NOISE, walk)


def test_it_follows_two_lumps_and_knows_how_well() -> None:
    torque, speed, truth = simulated(60.0, seed=3)
    filtered = filtering().run(torque, speed)
    late = score(told(filtered, truth["time_s"], 100), truth, 10.0)
    now = score(told(filtered, truth["time_s"], 0), truth, 10.0)
    assert late.share < now.share < 0.05
    assert late.torque < now.torque
    for of in (late, now):
        assert 0.88 < of.speed_within <= 1.0
        assert 0.88 < of.torque_within <= 1.0


def test_it_is_sure_of_more_the_longer_it_waits() -> None:
    torque, speed, _ = simulated(5.0, seed=1)
    filtered = filtering().run(torque, speed)
    stds = np.array([filtered.smoothed(lag)[1] for lag in (0, 20, 100, 200)])
    assert np.all(np.diff(stds[:, BIT_SPEED]) < 0)
    assert np.all(np.diff(stds[:, BIT_TORQUE]) < 0)


def test_the_likeliest_walk_is_the_true_one() -> None:
    torque, speed, _ = simulated(60.0, seed=2)
    walks = [WALK / 100, WALK, WALK * 100]
    found = max(walks, key=lambda walk: filtering(walk).run(torque, speed).likelihood(1000))
    assert found == WALK


def test_a_late_answer_is_for_its_own_time_and_ends_where_nothing_more_is_heard() -> None:
    torque, speed, truth = simulated(5.0, seed=1)
    states, _ = filtering().run(torque, speed).smoothed(50)
    assert np.isnan(states[-50:]).all()
    assert np.isfinite(states[:-50]).all()
    assert told(filtering().run(torque, speed), truth["time_s"], 50).time is truth["time_s"]


def test_a_rig_as_two_lumps_keeps_its_inertia_compliance_and_friction() -> None:
    real = rig(
        PIPE,
        COLLAR.model_copy(update={"coulomb_friction": 2.0, "static_friction": 2.0}),
        top_drive=DRIVE,
        bit={"inertia": 50.0},
    )
    of = Lumps.of(real)
    inertia = sum(component.inertia(part) for part in real.string)
    assert of.top_inertia + of.bit_inertia == pytest.approx(2050.0 + inertia)
    assert of.top_inertia - of.bit_inertia == pytest.approx(1950.0)
    assert 1 / of.stiffness == pytest.approx(sum(1 / component.stiffness(part) for part in real.string))
    assert (2 * of.viscous, 2 * of.coulomb) == pytest.approx((0.02 * 1500, 2.0 * 150))


def test_it_hears_the_string_through_the_gear() -> None:
    time = np.linspace(0.0, 0.2, 21)
    plain = rig(PIPE, top_drive=DRIVE)
    geared = rig(
        PIPE,
        top_drive={**DRIVE, "gear_ratio": 4.0},
        measurement={
            "torque_noise": plain.measurement.torque_noise / 4,
            "speed_noise": plain.measurement.speed_noise * 4,
        },
    )
    tuning = Tuning(walk=WALK, excess=3.0)
    by_plain = watched(plain, {"motor_torque_nm": 4e3 + time, "motor_speed_rad_s": time}, tuning)
    by_geared = watched(geared, {"motor_torque_nm": 1e3 + time / 4, "motor_speed_rad_s": 4 * time}, tuning)
    np.testing.assert_allclose(by_plain.states, by_geared.states, rtol=1e-9, atol=1e-9)


def test_the_more_noise_stands_for_what_lumps_cannot_do_the_less_it_claims() -> None:
    time = np.linspace(0.0, 0.2, 21)
    surface = {"motor_torque_nm": time, "motor_speed_rad_s": time}
    sure, unsure = (
        watched(rig(PIPE, top_drive=DRIVE), surface, Tuning(WALK, excess)) for excess in (1.0, 30.0)
    )
    assert np.all(unsure.smoothed(0)[1] > sure.smoothed(0)[1])
