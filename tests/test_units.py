"""Quantities as people write them: read exactly, or refused with what would be right."""

import math
import re

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.units import factor, registry, to_si

INCH = 0.0254
FOOT_POUND = 0.3048 * 4.4482216152605


@pytest.mark.parametrize(
    ("text", "unit", "si"),
    [
        ("5 in", "m", 5 * INCH),
        ('5"', "m", 5 * INCH),
        ("146.529 mm", "m", 0.146529),
        ("5000 ft", "m", 1524.0),
        ("120 rpm", "rad/s", 4 * math.pi),
        ("120 RPM", "rad/s", 4 * math.pi),
        ("2 rev/s", "rad/s", 4 * math.pi),
        ("2 rps", "rad/s", 4 * math.pi),
        ("90 °/s", "rad/s", math.pi / 2),
        ("8 kft*lbf", "N*m", 8000 * FOOT_POUND),
        ("8 kft-lbf", "N*m", 8000 * FOOT_POUND),
        ("8 kft·lbf", "N*m", 8000 * FOOT_POUND),
        ("8 ft.lbf", "N*m", 8 * FOOT_POUND),
        ("8 ft-lbs", "N*m", 8 * FOOT_POUND),
        ("8 ft-lb", "N*m", 8 * FOOT_POUND),
        ("8 kft-lb", "N*m", 8000 * FOOT_POUND),
        ("8 kft·lb", "N*m", 8000 * FOOT_POUND),
        ("120 1/min", "rad/s", 4 * math.pi),
        ("120 r/min", "rad/s", 4 * math.pi),
        ("120 min⁻¹", "rad/s", 4 * math.pi),
        ("120 rev·min⁻¹", "rad/s", 4 * math.pi),
        ("10 kN·m", "N*m", 1e4),
        ("10 kN⋅m", "N*m", 1e4),
        ("10 kN.m", "N*m", 1e4),
        ("10 kN m", "N*m", 1e4),
        ("10 kNm", "N*m", 1e4),
        ("80Nm", "N*m", 80.0),
        ("8 daN*m", "N*m", 80.0),
        ("7850 kg/m³", "kg/m^3", 7850.0),
        ("7850 kg·m⁻³", "kg/m^3", 7850.0),
        ("2900 kg*m**2", "kg*m^2", 2900.0),
        ("0.02 N·m·s/(rad·m)", "N*m*s/rad/m", 0.02),
        ("11.5e6 psi", "Pa", 7.9289708871e10),
        ("5 ms", "s", 5e-3),
        ("0.1 kHz", "Hz", 100.0),
        ("-.5 m", "m", -0.5),
        (" 12 ", "m", 12.0),
        (12, "m", 12.0),
    ],
)
def test_a_quantity_is_read_as_written_on_a_rig(text: object, unit: str, si: float) -> None:
    assert to_si(text, unit) == pytest.approx(si, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "unit", "right"),
    [
        ("9 5/8 in", "m", "9.625 in"),  # Pint would take it for 9 · 5 / 8 in
        ('9 5/8"', "m", "9.625 inch"),
        ("1/2 in", "m", "0.5 in"),
        ("1,502.54 m", "m", "a point"),
        ("1,5 m", "m", "a point"),
        ("19.5 lb/ft", "m", "1 m"),
        ("5 kN", "N*m", "1 N*m"),
        ("8 ft*lb", "N*m", "1 N*m"),  # a mass
        ("2 Hz", "rad/s", "1 rad/s"),  # Pint would take it for 2 rad/s
        ("120 rpm", "Hz", "1 Hz"),
        ("2 ft 3 in", "m", "1 m"),
        ("5 furlings", "m", "furlings"),
        ("60 %", "m", "%"),
        ("in", "m", "1 m"),
        ("", "m", "1 m"),
        ("nan m", "m", "1 m"),
        ("1e999 m", "m", "not finite"),
        (math.nan, "m", "not finite"),
        (10**400, "m", "not finite"),
        ("2 m**9**9**9", "m", "1 m"),  # would be computed for ever
        (True, "m", "1 m"),
        ([5], "m", "1 m"),
        (None, "m", "1 m"),
    ],
)
def test_what_could_be_mistaken_is_refused_with_what_would_be_right(
    text: object, unit: str, right: str
) -> None:
    with pytest.raises(ValueError, match=re.escape(right)):
        to_si(text, unit)


@given(st.one_of(st.text(), st.text("0123456789.eE+-*/^() mNskgradft,\"'°·²%"), st.binary(), st.integers()))
def test_any_value_is_a_finite_number_or_a_value_error(value: object) -> None:
    try:
        number = to_si(value, "N*m")
    except ValueError:
        return
    assert math.isfinite(number)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_bare_number_is_si_already(number: float) -> None:
    assert to_si(number, "m") == number
    assert to_si(repr(number), "m") == number


def test_factors() -> None:
    assert factor("1/min", "rad/s") == pytest.approx(2 * math.pi / 60)
    assert factor("rad/s", "rpm") == pytest.approx(60 / (2 * math.pi))
    assert factor("N*m", "kft*lbf") == pytest.approx(1 / (1000 * FOOT_POUND))
    with pytest.raises(ValueError, match="does not measure in rpm"):
        factor("N*m", "rpm")


OWN = {"octet", "B", "byte", "rev", "RPM", "ftlbf", "ft_lbf", "kftlbf", "kft_lbf"}


def test_every_unit_of_a_rig_is_pints_own_but_for_the_oilfields() -> None:
    pints: pint.UnitRegistry[float] = pint.UnitRegistry()
    names = {name for name in registry()._units if name not in OWN}
    assert {"meter", "ft", "lbf", "psi", "rpm"} <= names
    for name in names:
        ours, theirs = (units.Quantity(1.0, name).to_root_units() for units in (registry(), pints))
        assert (ours.magnitude, str(ours.units)) == (theirs.magnitude, str(theirs.units)), name
