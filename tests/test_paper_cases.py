"""Systems that others published, by our models, within 3 % of an independent simulation."""

import math

import numpy as np
import pytest

from vsensor.config import Component
from vsensor.estimator.modes import torsional_modes
from vsensor.paper import cases
from vsensor.paper.cases import Outcome
from vsensor.paper.shaft import Trace


@pytest.fixture(scope="module")
def outcomes() -> tuple[Outcome, ...]:
    return cases.outcomes(
        cases.four_inertias(10e3, 120.0),
        cases.four_inertias(12e3, 120.0),
        cases.neutral_delay(10.0, 120.0, 300),
        cases.neutral_delay(15.0, 120.0, 300),
    )


def test_every_outcome_is_within_three_percent(outcomes: tuple[Outcome, ...]) -> None:
    assert len(outcomes) == 9
    for outcome in outcomes:
        assert outcome.ours == pytest.approx(outcome.expected, rel=0.03, abs=1e-3), outcome.quantity


def test_four_inertias_stay_stuck_at_8_kilonewton_metres() -> None:
    motion = cases.four_inertias(8e3, 200.0)
    # The step of torque shakes it loose once; after that it never moves again.
    assert [event.regime for event in motion.events] == ["held", "sliding", "held"]
    assert np.all(motion.speeds[-1][motion.time > 12] == 0)
    assert motion.torque[-1] == pytest.approx(8e3, rel=1e-6)


def test_four_inertias_settle_at_a_slower_and_smaller_cycle() -> None:
    """After minutes the cycle is still within 3 % of what was told after one or two."""
    motion = cases.four_inertias(10e3, 400.0)
    late = motion.time > 300
    assert cases.period(motion.times("sliding")) == pytest.approx(8.25, rel=0.01)
    assert motion.speeds[-1][late].max() == pytest.approx(6.78, rel=0.015)
    assert motion.speeds[-1][late].min() == 0


def test_the_delayed_shaft_does_not_hang_on_its_grid() -> None:
    coarse, fine = (cases.neutral_delay(10.0, 60.0, steps) for steps in (200, 800))
    periods = [cases.period(cases.breaks_loose(trace)) for trace in (coarse, fine)]
    assert periods[0] == pytest.approx(periods[1], rel=1e-3)
    assert np.interp(40.0, *coarse) == pytest.approx(np.interp(40.0, *fine), abs=0.02)


def test_the_delayed_shaft_turns_steadily_where_motor_and_rock_balance() -> None:
    """c_a (Ω − ω) = c_b ω + T(ω): at 15 rad/s the motor gives way by a quarter."""
    speed = cases.neutral_delay(15.0, 150.0, 200).value[-1]
    rock = cases.KINETIC + (cases.STATIC - cases.KINETIC) * math.exp(-speed / cases.FADE_SPEED)
    assert 2000.0 * (15.0 - speed) == pytest.approx(0.03 * speed + rock, rel=1e-6)


def test_modes_by_two_ports_are_the_estimators() -> None:
    density, c = 7850.0, 2787.6
    modulus = c**2 * density

    def bar(impedance: float, length: float) -> Component:
        diameter = (32 * impedance / math.sqrt(density * modulus) / math.pi) ** 0.25
        return Component(
            length=length, outer_diameter=diameter, inner_diameter=0, shear_modulus=modulus, density=density
        )

    expected = torsional_modes((bar(498.26, 2270), bar(1858.65, 230)), 0.0, 6)
    found = cases.modes(cases.PIPE_AND_COLLARS, below_hz=float(expected[-1]) + 0.01)
    assert found == pytest.approx(expected, rel=1e-9)


def test_too_few_cycles_have_no_period() -> None:
    assert math.isnan(cases.period(np.array([1.0, 2.0])))
    assert cases.period(np.array([0.0, 1.0, 3.0, 5.0])) == 2.0


def test_a_speed_breaks_loose_when_it_leaves_zero() -> None:
    trace = Trace(np.arange(6.0), np.array([0.0, 0.0, 1.0, 0.0, 0.0, 2.0]))
    assert cases.breaks_loose(trace).tolist() == [2.0, 5.0]
