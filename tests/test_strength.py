"""What a component bears in torsion, and what hangs on it, by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.strings import COLLAR, PIPE, strings
from vsensor.config import Component
from vsensor.config.well import Station, Wellbore
from vsensor.estimator.component import GRAVITY, buoyed_weight
from vsensor.estimator.strength import Limit, torsional_limit
from vsensor.estimator.tension import greatest_tension, hanging_weight
from vsensor.units import to_si

G105 = Component(  # 5 in, 19.5 lb/ft: API RP 7G, table 2, new pipe
    length=3000,
    outer_diameter=to_si("5 in", "m"),
    inner_diameter=to_si("4.276 in", "m"),
    torsional_strength=to_si("57.6 kft*lbf", "N*m"),
    tensile_strength=to_si("553.8 klbf", "N"),
)


def limited(part: Component, **limits: float | None) -> Component:
    return part.model_copy(update=limits)


def test_tension_takes_its_share_of_the_strength_in_torsion() -> None:
    """Three fifths of the tensile strength leave four fifths of the torsional one."""
    part = limited(PIPE, torsional_strength=50e3, tensile_strength=2e6)
    assert torsional_limit(part, 1.2e6) == Limit(
        pytest.approx(40e3),  # type: ignore[arg-type]
        "torsional strength under tension",
    )
    assert torsional_limit(part, 0.0) == Limit(50e3, "torsional strength under tension")


def test_the_limit_is_that_of_the_recommended_practice() -> None:
    """Q = 0.096167 J/D √(Y² − (P/A)²) in inches, psi and ft·lbf: 48 446 for G-105 under 300 000 lbf."""
    moment, area = math.pi / 32 * (5**4 - 4.276**4), math.pi / 4 * (5**2 - 4.276**2)
    by_hand = 0.096167 * moment / 5 * math.sqrt(105e3**2 - (300e3 / area) ** 2)
    assert by_hand == pytest.approx(48_446, abs=30)
    limit = torsional_limit(G105, to_si("300 klbf", "N"))
    assert limit is not None
    assert limit.torque == pytest.approx(to_si(f"{by_hand} ft*lbf", "N*m"), rel=2e-3)


@pytest.mark.parametrize("tension", [2e6, 3e6, -3e6])
def test_nothing_is_left_of_a_pipe_that_tears(tension: float) -> None:
    part = limited(PIPE, torsional_strength=50e3, tensile_strength=2e6)
    assert torsional_limit(part, tension) == Limit(0.0, "torsional strength under tension")


def test_the_weaker_of_body_and_connection_sets_the_limit() -> None:
    part = limited(PIPE, torsional_strength=50e3, make_up_torque=42e3)
    assert torsional_limit(part, 1e9) == Limit(42e3, "make-up torque")
    weak = limited(part, torsional_strength=41e3)
    assert torsional_limit(weak, 1e9) == Limit(41e3, "torsional strength")
    assert torsional_limit(limited(part, tensile_strength=1e6), 0.8e6) == Limit(
        pytest.approx(30e3),  # type: ignore[arg-type]
        "torsional strength under tension",
    )


def test_what_has_no_strength_given_has_no_limit() -> None:
    assert torsional_limit(PIPE, 1e5) is None
    assert torsional_limit(limited(PIPE, tensile_strength=1e6), 1e5) is None


def test_the_weight_below_hangs_on_each_depth() -> None:
    heavy = COLLAR.model_copy(update={"outer_diameter": 0.2, "inner_diameter": 0.1, "length": 100.0})
    light = heavy.model_copy(
        update={"outer_diameter": math.sqrt(0.02), "length": 1000.0}
    )  # a third of the steel
    of_collar = math.pi / 4 * 0.03 * 7850 * 100 * GRAVITY
    of_pipe = of_collar * 10 / 3
    depths = np.array([0.0, 500.0, 1000.0, 1050.0, 1100.0])
    expected = [of_pipe + of_collar, of_pipe / 2 + of_collar, of_collar, of_collar / 2, 0.0]
    np.testing.assert_allclose(hanging_weight((light, heavy), depths), expected, rtol=1e-12, atol=1e-6)


@given(strings(), st.floats(0, 2e3))
def test_mud_bears_its_share(string: tuple[Component, ...], mud: float) -> None:
    depths = np.linspace(0, sum(part.length for part in string), 20)
    in_air = hanging_weight(string, depths)
    assert (np.diff(in_air) < 0).all()
    assert in_air[-1] == pytest.approx(0, abs=1e-6)
    told = hanging_weight(string, depths, mud)
    np.testing.assert_allclose(told, in_air * (1 - mud / 7850), rtol=1e-9, atol=1e-5)


def test_what_lies_flat_hangs_on_nothing() -> None:
    """1000 m down, a quarter of a circle of 300 m, and on along the level: what hangs is 1300 m of pipe."""
    quarter = 300 * math.pi / 2
    survey = tuple(
        Station(measured_depth=depth, inclination=math.radians(angle), azimuth=0)
        for depth, angle in ((0, 0), (1000, 0), (1000 + quarter, 90), (4000, 90))
    )
    mud = Wellbore(mud_density=1200, friction_factor=0.2)
    depths = np.array([0.0, 1000.0, 1000 + quarter / 2, 1000 + quarter, 3000.0])
    told = greatest_tension((G105.model_copy(update={"length": 4000.0}),), depths, survey, mud)
    hangs = [1300, 300, 300 * (1 - math.sqrt(0.5)), 0, 0]
    np.testing.assert_allclose(told, buoyed_weight(G105, 1200) * np.array(hangs), rtol=1e-9, atol=1e-4)
    pushing = mud.model_copy(update={"weight_on_bit": 100e3})
    pushed = greatest_tension((G105.model_copy(update={"length": 4000.0}),), depths, survey, pushing)
    np.testing.assert_allclose(pushed, [*told[:2], *(told[2:] - 100e3)], rtol=1e-9, atol=1e-4)
