"""Quantities as people write them, and the SI values that the program computes with."""

import math
from functools import cache

import pint

# Pint holds an angle to be a pure number, so that a frequency and an angular speed would convert
# into one another without the factor 2π. The two families are told apart by name.
_FREQUENCY = ("hertz", "revolutions_per_second")
_ANGULAR = ("radian", "revolution", "turn", "degree", "rpm")


@cache
def registry() -> "pint.UnitRegistry[float]":
    """The one registry of units, with the oilfield's own added."""
    units: pint.UnitRegistry[float] = pint.UnitRegistry(cache_folder=":auto:")
    units.define("ftlbf = foot * pound_force = ft_lbf")
    units.define("kftlbf = 1000 * foot * pound_force = kft_lbf")
    return units


def to_si(value: object, unit: str) -> float:
    """Read a quantity: text with a unit, or a bare number that is in `unit` already.

    Raises ValueError with a sentence that says what was wrong and shows what would be right.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ValueError(f'{value!r} is no quantity: write a number in {unit}, or text such as "1 {unit}"')
    number = _parse(value, unit) if isinstance(value, str) else float(value)
    if not math.isfinite(number):
        raise ValueError(f"{value!r} is not finite")
    return number


def from_si(value: float, si_unit: str, unit: str) -> float:
    """Convert an SI value to the unit that people read, by a factor (no offsets)."""
    return value * factor(si_unit, unit)


@cache
def factor(unit: str, other: str) -> float:
    """How many `other` make one `unit`; ValueError where the two do not measure the same."""
    return to_si(f"1 {unit}", other)


def _parse(text: str, unit: str) -> float:
    units = registry()
    try:
        quantity = units.Quantity(text)
    except Exception as error:  # pint raises whatever its tokenizer meets; all mean «not a quantity»
        raise ValueError(f'{text!r} is no quantity: write for example "1 {unit}"') from error
    if quantity.unitless and "rad" not in text:
        return float(quantity.magnitude)
    target = units.Unit(unit)
    if quantity.dimensionality != target.dimensionality or _mixes_turns(str(quantity.units), str(target)):
        raise ValueError(f'{text!r} does not measure in {unit}: write for example "1 {unit}"')
    return float(quantity.to(target).magnitude)


def _mixes_turns(one: str, other: str) -> bool:
    """Whether one is a frequency and the other an angular speed."""

    def either(a: str, b: str) -> bool:
        return any(w in a for w in _FREQUENCY) and any(w in b for w in _ANGULAR)

    return either(one, other) or either(other, one)
