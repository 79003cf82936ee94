"""The simulated wells' own truth: the fine grid against closed forms."""

from pathlib import Path

import numpy as np
import pytest

from tests import leapfrog
from tests.leapfrog import Drive, Floats, Law, Part, Well, longest_step, simulate
from vsensor.jit import COMPILED

pytestmark = pytest.mark.skipif(not COMPILED, reason="millions of steps: too slow without the compiler")

PIPE = Part(500.0, 0.0635, 0.0543)
COLLARS = Part(300.0, 0.0826, 0.0357)
TORQUE = 7000.0


def impedance(part: Part) -> float:
    return float(part.moment * np.sqrt(part.rho * part.G))


def pushed(*string: Part, damping: float = 400.0, torque: float = TORQUE, duration: float = 3.0) -> Well:
    """A string at rest that a constant torque is put on, with a bit in something viscous."""
    return Well(
        string=string, command=((0.0, torque),), law=((0.0, Law(viscous=damping)),), duration=duration
    )


def turned(**changes: object) -> Well:
    """A string that is held at 10 rad/s, and stick-slips."""
    law = Law(viscous=10.0, kinetic=3e3, static=6e3, stribeck=1.5)
    return Well(
        string=(PIPE._replace(c=0.02, fs=0.3), COLLARS),
        command=((0, 0), (2, 10)),
        law=((0.0, law),),
        drive=Drive(kp=20e3, ki=8e3, limit=50e3),
        drive_inertia=2000.0,
        bit_inertia=50.0,
        duration=10.0,
    )._replace(**changes)  # type: ignore[arg-type]


def test_nothing_of_the_sensor_is_in_it() -> None:
    assert "vsensor" not in Path(leapfrog.__file__).read_text()


@pytest.mark.parametrize("viscous", [0.0, 0.1])
@pytest.mark.parametrize("coulomb", [0.0, 2.0])
def test_in_the_end_torque_is_what_friction_takes(viscous: float, coulomb: float) -> None:
    """What turns meets kinetic friction, the half cells at both ends no less than all between."""
    torque = 1400.0  # little enough that it turns slowly, at a radian a second where all friction is told
    part = PIPE._replace(c=viscous, fs=1.5 * coulomb, fd=coulomb)
    well = pushed(part, duration=5.0)._replace(command=((0.0, 0.0), (0.5, torque)))
    speed = (torque - coulomb * part.length) / (400.0 + viscous * part.length)
    record = simulate(well)
    for values, expected in (
        (record.bit_speed, speed),
        (record.motor_speed, speed),
        (record.bit_torque, 400.0 * speed),
    ):
        assert values[-1] == pytest.approx(expected, rel=2e-5)


def test_the_papers_step_is_its_closed_form() -> None:
    """ω₁ = (2T₀/(ζ+D)) (1 − exp(−(ζ+D)(t−θ)/J)) from θ to 3θ, and ω₀ = T₀/ζ up to 2θ."""
    part = Part(4000.0, 0.0841, 0.074942, rho=8009.0, G=79.6e9)
    record = simulate(pushed(part, duration=3.8)._replace(bit_inertia=2500.0))
    theta, zeta = part.travel_s, impedance(part)
    assert theta == pytest.approx(1.268798)
    assert zeta == pytest.approx(733.009)
    rate = (zeta + 400.0) / 2500.0
    exact = 2 * TORQUE / (zeta + 400.0) * -np.expm1(-rate * np.maximum(record.time - theta, 0))
    np.testing.assert_allclose(record.bit_speed, exact, atol=0.01)
    np.testing.assert_array_less(np.abs(record.bit_speed[record.time < theta - 0.02]), 1e-6)
    early = record.time < 2 * theta - 0.02
    # The torque begins between two samples of the grid: what a front rings by dies away behind it.
    assert np.mean(record.motor_speed[early]) == pytest.approx(TORQUE / zeta, rel=1e-3)


def test_a_change_of_impedance_reflects_and_transmits() -> None:
    """Of a step T₀: 2T₀/(ζ₁+ζ₂) goes on, and comes out of an end that matches as it is."""
    first, second = PIPE._replace(length=800.0), COLLARS._replace(length=800.0)
    above, below = impedance(first), impedance(second)
    record = simulate(pushed(first, second, damping=below, duration=0.9))
    through = 2 * TORQUE / (above + below)
    back = TORQUE / above * (1 - 2 * (below - above) / (above + below))
    arrival, echo = first.travel_s + second.travel_s, 2 * first.travel_s
    assert within(record.time, record.motor_speed, 0.1, echo - 0.1) == pytest.approx(TORQUE / above, rel=0.01)
    assert within(record.time, record.motor_speed, echo + 0.1, 0.9) == pytest.approx(back, rel=0.01)
    assert within(record.time, record.bit_speed, 0.0, arrival - 0.02) == pytest.approx(0, abs=1e-3)
    assert within(record.time, record.bit_speed, arrival + 0.1, 0.9) == pytest.approx(through, rel=0.01)


def within(time: Floats, values: Floats, start: float, end: float) -> float:
    """Mean from start to end."""
    return float(np.mean(values[(time > start) & (time < end)]))


def test_half_the_grid_is_the_same_well() -> None:
    well = turned()
    step = longest_step(well.string)
    coarse, fine = (simulate(well, step_s=of) for of in (step, step / 2))
    assert np.ptp(fine.bit_speed[500:]) > 15  # it does stick-slip
    for name, scale in (("bit_speed", 20.0), ("bit_torque", 6e3), ("motor_torque", 10e3)):
        error = np.abs(getattr(coarse, name) - getattr(fine, name))
        assert np.sqrt(np.mean(error**2)) < 1e-3 * scale, name


def test_a_string_rests_where_the_wall_holds_it() -> None:
    """Wound up slowly it twists as deep as friction f lets it, by T²/(2f GJ), and goes half the way back."""
    part, most = PIPE._replace(fs=4.0), 1900.0
    slowly = ((0.0, 0.0), (20.0, most), (25.0, most), (45.0, 0.0))
    record = simulate(pushed(part, duration=50.0)._replace(command=slowly), step_s=5e-4)
    twist = most**2 / (2 * part.fs * part.G * part.moment)
    angle = np.cumsum(record.motor_speed) / 100
    assert angle[2400] == pytest.approx(twist, rel=0.01)
    assert angle[-1] == pytest.approx(twist / 2, rel=0.02)
    assert not record.bit_speed.any()
    for still in (within(record.time, np.abs(record.motor_speed), *of) for of in ((22, 25), (47, 50))):
        assert still == 0  # nothing creeps


def test_a_bit_rests_below_what_breaks_it_loose() -> None:
    law = Law(kinetic=2e3, static=5e3, stribeck=1.5)
    well = pushed(PIPE, duration=30.0)._replace(law=((0.0, law),))
    held, loose = (
        simulate(well._replace(command=((0, 0), (20, most))), step_s=5e-4) for most in (4400, 5100)
    )
    assert held.bit_speed.max() < 2 * law.regular
    assert held.bit_torque[-1] == pytest.approx(4400, rel=0.01)
    assert loose.bit_speed[-1] > 10


def test_the_drive_holds_its_speed_within_its_limit_and_winds_nothing_up() -> None:
    drive = Drive(kp=20e3, ki=8e3, limit=6e3)
    record = simulate(turned(drive=drive, command=((0, 10),), law=((0.0, Law(viscous=50.0)),), duration=30.0))
    assert record.motor_torque.max() == 6e3
    assert record.motor_speed[-1] == pytest.approx(10, rel=1e-3)
    assert record.motor_speed.max() < 11.5


def test_a_drive_tells_its_torque_late() -> None:
    record = simulate(pushed(PIPE)._replace(torque_lag=0.5))
    np.testing.assert_allclose(record.motor_torque, TORQUE * -np.expm1(-record.time / 0.5), atol=2)


def test_rock_and_readings_are_as_noisy_as_told() -> None:
    law = Law(viscous=100.0, kinetic=2500.0, static=2500.0)
    well = turned(law=((0.0, law),), rock=(400.0, 0.3), duration=300.0)
    quiet, noisy = (
        simulate(well._replace(torque_noise=torque, speed_noise=speed), step_s=1e-3)
        for torque, speed in ((0, 0), (80, 0.01))
    )
    sliding = quiet.bit_speed > 1
    rock = (quiet.bit_torque - 2500 - 100 * quiet.bit_speed)[sliding]
    assert np.std(rock) == pytest.approx(400, rel=0.1)
    assert np.corrcoef(rock[:-30], rock[30:])[0, 1] == pytest.approx(np.exp(-1), abs=0.1)
    assert np.std(noisy.motor_torque - quiet.motor_torque) == pytest.approx(80, rel=0.02)
    assert np.std(noisy.motor_speed - quiet.motor_speed) == pytest.approx(0.01, rel=0.02)


def test_law_and_weight_change_as_told() -> None:
    law = Law(kinetic=2e3, static=2e3)
    soft, hard = law._replace(viscous=50.0), law._replace(viscous=150.0)
    record = simulate(turned(law=((0, soft), (10, soft), (20, hard)), duration=30.0, swing=(0.2, 0.25)))
    for start, viscous in ((8.0, 50.0), (15.0, 100.0), (29.0, 150.0)):
        at = np.flatnonzero(record.time >= start)[0]
        expected = 2e3 * (1 + 0.2 * np.sin(np.pi / 2 * record.time[at])) + viscous * record.bit_speed[at]
        assert record.bit_torque[at] == pytest.approx(expected, rel=1e-3)


def test_the_same_seed_draws_the_same_noise() -> None:
    well = turned(rock=(400.0, 0.3), torque_noise=80.0, duration=1.0)
    first, again, other = (simulate(well, seed).motor_torque for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.all(first != other)
