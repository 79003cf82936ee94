"""The profile: what the estimator tells of the whole string, and the message that is made of it."""

import math
from collections.abc import Iterable

import numpy as np
import pytest

from tests.observer import LINEAR, drilled, pinned
from tests.strings import BIT, COLLAR, DRIVE, PIPE, rig
from vsensor.config import Component, Rig
from vsensor.config.well import Station, Wellbore
from vsensor.estimator import component
from vsensor.estimator.along import SPEED, TORQUE
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.figures import figures
from vsensor.messages import Estimate, Profile, Tick
from vsensor.messages.vsensor_pb2 import GOOD, UNCERTAIN
from vsensor.quality import Reason
from vsensor.service.engine import Engine
from vsensor.service.profile import RATE_HZ, Profiler, profile_of, reckon
from vsensor.simulate.rig import Reading, SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

STRONG = {"torsional_strength": 100e3, "tensile_strength": 3e6, "make_up_torque": 41e3}
RIG = rig(
    PIPE.model_copy(update=STRONG),
    COLLAR.model_copy(update={"make_up_torque": 30e3}),
    bit=BIT,
    top_drive=DRIVE,
)
HELD = rig(*RIG.string, bit={"inertia": 50.0, "kinetic_torque": 20e3, "static_torque": 60e3}, top_drive=DRIVE)
NS = 1_000_000_000
HOLDS = {"inertia": 50.0, "kinetic_torque": 20e3, "static_torque": 60e3}
"""A bit that nothing turns."""


def test_a_string_wound_up_and_held_bears_one_torque_all_along() -> None:
    estimator = Estimator(rig(PIPE, COLLAR, bit=HOLDS))
    estimator.run(np.full(400, 7e3), np.zeros(400))
    told = estimator.profile()
    np.testing.assert_allclose(told[TORQUE], 7e3, rtol=1e-4)
    np.testing.assert_allclose(told[SPEED], 0.0, atol=2e-3)
    assert estimator.top() == pytest.approx((told[SPEED, 0], told[TORQUE, 0]), abs=1e-9)


def test_the_wall_takes_its_torque_evenly() -> None:
    """1500 m at 10 rad/s against 0.02 N·m·s/rad and 0.5 N·m a metre: 0.7 N·m less each metre."""
    rough = PIPE.model_copy(update={"coulomb_friction": 0.5, "static_friction": 0.5})
    estimator = Estimator(rig(rough, bit={"inertia": 50.0, "viscous_friction": 795.0}))
    estimator.run(np.full(400, 9e3), np.full(400, 10.0))
    told = estimator.profile()
    # Half a step, of sections that have a whole number of them.
    rounding = 0.5 * (300.0 / (estimator.line.round_trip / 2)).max()
    expected = 9e3 - 0.7 * estimator.stations.depth
    np.testing.assert_allclose(told[TORQUE], expected, atol=0.7 * rounding * (1 + 1e-6))
    assert told[TORQUE, [0, -1]] == pytest.approx(expected[[0, -1]], abs=0.1)


def test_noise_moves_it_by_no_more_than_is_stated() -> None:
    """The same string heard with and without noise; its rock is calm, of which the stated has a part."""
    told = []
    for noisy in (True, False):
        record = drilled(LINEAR, np.full(2500, 4e3), 0.0, 3, noisy=noisy)
        estimator = pinned(LINEAR, 0)
        profiles = []
        for torque, speed in zip(record.torque.tolist(), record.speed.tolist(), strict=True):
            estimator.step(torque, speed)
            profiles.append(estimator.profile().copy())
        told.append(np.array(profiles[500:]))
    moved = (told[0] - told[1]).std(axis=0) / estimator.profile_noise
    assert moved.max() < 1.25
    assert moved.min() > 0.2
    assert estimator.profile_noise[SPEED, -1] == pytest.approx(estimator.noise[0], rel=1e-5)


def test_with_one_channel_lost_it_is_told_on_and_stays_continuous() -> None:
    bit = {"inertia": 50.0, "viscous_friction": 60.0}
    estimator = Estimator(rig(PIPE, COLLAR, bit=bit, top_drive={"inertia": 500.0}))
    wall = PIPE.length * PIPE.viscous_friction
    torque = (60.0 + wall) * 10.0
    estimator.run(np.full(1500, torque), np.full(1500, 10.0))
    before = estimator.profile().copy()
    estimator.run(np.full(400, math.nan), np.full(400, 10.0))
    np.testing.assert_allclose(estimator.profile(), before, rtol=0.03)


def profiles(of: Rig, ticks: Iterable[tuple[float, float]]) -> list[tuple[Estimate, Profile]]:
    """Each profile that a daemon would publish, with its estimate, for motor torques and speeds."""
    engine = Engine(of)
    profiler = Profiler(of, engine.estimator)
    told = []
    for number, (torque, speed) in enumerate(ticks):
        time_ns = round(number * NS / of.loop.rate)
        reasons = int(Reason.STALE_TORQUE) if math.isnan(torque) else 0
        tick = Tick(
            number=number, time_ns=time_ns, motor_torque_nm=torque, motor_speed_rad_s=speed, reasons=reasons
        )
        estimate = engine.step(tick)
        if noted := profiler.note(estimate):
            told.append((estimate, profile_of(reckon(noted))))
    return told


def test_what_the_wall_takes_is_the_power_lost() -> None:
    """10 rad/s against 30 N·m·s/rad along the pipe: 3 of the 90 kW that are fed in."""
    engine = Engine(RIG)
    for number in range(2400):
        engine.step(Tick(number=number, motor_torque_nm=9e3, motor_speed_rad_s=10.0))
    told = figures(engine.window, engine.recent_s)
    assert told.top_power_w == pytest.approx(90e3, rel=1e-3)
    assert told.lost_power_w == pytest.approx(3e3, rel=0.02)
    assert told.stuck_share == told.back_rotation_share == told.back_rotation_turns == 0


def steady(torque: float, seconds: float = 5.0) -> list[Profile]:
    """Profiles of the string wound up and held."""
    return [profile for _, profile in profiles(HELD, [(torque, 0.0)] * round(seconds * 100))]


def test_it_comes_ten_times_a_second_once_the_confirmed_answer_is_known() -> None:
    told = profiles(RIG, [(5e3, 0.0)] * 500)
    assert {number % 10 for number in (profile.number for _, profile in told)} == {0}
    warm_up = Estimator(RIG).warm_up
    assert len(told) == pytest.approx((5 - warm_up) * RATE_HZ, abs=1)
    for estimate, profile in told:
        assert (profile.number, profile.time_ns) == (estimate.number, estimate.confirmed_time_ns)
        assert (profile.quality, profile.reasons) == (GOOD, 0)
        assert profile.quality == estimate.quality


def test_a_slow_loop_has_one_at_each_tick() -> None:
    slow = RIG.model_copy(update={"loop": RIG.loop.model_copy(update={"rate": 8.0})})
    numbers = [profile.number for _, profile in profiles(slow, [(5e3, 0.0)] * 60)]
    assert np.diff(numbers).tolist() == [1] * (len(numbers) - 1)


def test_every_number_has_its_deviation_and_every_depth_every_number() -> None:
    last = steady(5e3)[-1]
    arrays = [getattr(last, field.name) for field in Profile.DESCRIPTOR.fields if field.is_repeated]
    assert len(arrays) == 9
    assert {len(values) for values in arrays} == {len(last.depth_m)}
    noise = RIG.measurement.torque_noise
    assert all(0.5 * noise < deviation < 5 * noise for deviation in last.torque_std_nm)


def test_shear_stress_is_torque_by_the_section() -> None:
    """T ro/J; for the pipe's top worked out: 5 kN·m · 0.0635 m / 1.1882e-5 m⁴ = 26.72 MPa."""
    last = steady(5e3)[-1]
    assert last.shear_stress_pa[0] == pytest.approx(26.72e6, rel=1e-3)
    assert last.shear_stress_std_pa[0] == pytest.approx(last.torque_std_nm[0] * 26.72e6 / 5e3, rel=1e-3)
    collar = 5e3 * COLLAR.outer_diameter / 2 / component.polar_moment(COLLAR)
    assert last.shear_stress_pa[-1] == pytest.approx(collar, rel=1e-3)


def test_the_weakest_place_is_named() -> None:
    """Of one torque all along, the collar's 30 kN·m bear least; beyond them the margin is negative."""
    for torque, margin in ((15e3, 0.5), (33e3, -0.1)):
        last = steady(torque)[-1]
        assert last.weakest_component == "collar"
        assert last.weakest_depth_m >= PIPE.length
        assert last.weakest_limit_nm == 30e3
        assert last.weakest_limited_by == "make-up torque"
        assert last.weakest_torque_nm == pytest.approx(torque, rel=1e-3)
        assert last.weakest_torque_std_nm in last.torque_std_nm
        assert last.weakest_margin == min(last.margin) == pytest.approx(margin, abs=1e-3)
        assert last.torque_limit_nm[0] == 41e3


def test_a_component_without_strength_has_no_margin() -> None:
    bare = rig(PIPE, COLLAR.model_copy(update={"make_up_torque": 30e3}))
    (*_, (_, last)) = profiles(bare, [(5e3, 0.0)] * 500)
    pipe = list(last.depth_m).index(PIPE.length) + 1
    assert np.isnan(last.margin[:pipe]).all()
    assert np.isfinite(last.margin[pipe:]).all()
    assert last.weakest_component == "collar"
    (*_, (_, none)) = profiles(rig(PIPE), [(5e3, 0.0)] * 500)
    assert not none.HasField("weakest_margin")
    assert np.isnan(none.margin).all()


def test_what_its_own_weight_tears_bears_nothing() -> None:
    torn: Component = PIPE.model_copy(update={"torsional_strength": 50e3, "tensile_strength": 1e3})
    (*_, (_, last)) = profiles(rig(torn), [(5e3, 0.0)] * 500)
    assert last.torque_limit_nm[0] == 0
    assert last.weakest_margin == -math.inf
    assert last.torque_limit_nm[-1] == 50e3


def test_a_pipe_on_which_little_hangs_bears_more() -> None:
    """Laid flat at 300 m its own weight takes a smaller share of the strength than straight down."""
    part = PIPE.model_copy(update={"torsional_strength": 50e3, "tensile_strength": 5e5})
    limits = []
    for end in (0, math.pi / 2):
        survey = tuple(
            Station(measured_depth=depth, inclination=down, azimuth=0)
            for depth, down in ((0, 0), (300, 0), (600, end))
        )
        told = rig(part).model_copy(
            update={"survey": survey, "wellbore": Wellbore(mud_density=1200, friction_factor=0.0)}
        )
        (*_, (_, last)) = profiles(told, [(5e3, 0.0)] * 500)
        limits.append(last.torque_limit_nm[0])
    straight, flat = limits
    weight = component.buoyed_weight(part, 1200)
    assert straight == pytest.approx(50e3 * math.sqrt(1 - (weight * 1500 / 5e5) ** 2))
    assert flat == pytest.approx(50e3 * math.sqrt(1 - (weight * (300 + 600 / math.pi) / 5e5) ** 2))


def test_while_a_channel_is_silent_it_is_wider_and_uncertain() -> None:
    drilling = [(r.motor_torque, r.motor_speed) for r in _readings(30.0)]
    lost = [(math.nan, speed) for _, speed in drilling[2000:]]
    told = profiles(RIG, [*drilling[:2000], *lost])
    before, after = told[-110][1], told[-1][1]
    assert (before.quality, after.quality) == (GOOD, UNCERTAIN)
    for name in ("torque_std_nm", "speed_std_rad_s"):
        wider = np.array(getattr(after, name)) / np.array(getattr(before, name))
        assert (wider >= 1).all()
        assert wider[-1] > 1.5


def test_the_ends_are_the_surface_as_it_was_and_the_bit_as_it_is_confirmed() -> None:
    """In stick-slip: the top as the rig's truth has it at that time, the bottom the confirmed bit."""
    readings = _readings(40.0)
    told = profiles(RIG, [(r.motor_torque, r.motor_speed) for r in readings])
    times = [profile.time_ns / NS for _, profile in told]
    top = np.interp(times, [r.time_s for r in readings], [r.motor_speed for r in readings])
    noise = told[0][1].speed_std_rad_s[0] + RIG.measurement.speed_noise
    assert np.sqrt(np.mean((top - [p.speed_rad_s[0] for _, p in told]) ** 2)) < 1.5 * noise
    bottom = np.array([p.speed_rad_s[-1] - e.confirmed_bit_speed_rad_s for e, p in told])
    assert np.mean(np.abs(bottom) <= 2 * np.array([p.speed_std_rad_s[-1] for _, p in told])) > 0.9
    # At the bottom of the string stands what the rock takes and what turns the bit.
    given = np.array([e.confirmed_bit_torque_nm for e, _ in told])
    turning = np.array([p.torque_nm[-1] for _, p in told]) - given
    assert np.ptp([p.speed_rad_s[-1] for _, p in told]) > 20
    assert abs(turning.mean()) < 0.05 * np.abs(turning).max()


def _readings(seconds: float) -> list[Reading]:
    simulated = SimulatedRig(RIG, PLANS[Scenario.STICK_SLIP], seed=7)
    return [simulated.sample() for _ in range(round(seconds * RIG.loop.rate))]
