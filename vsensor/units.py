"""Quantities as people write them, and the SI values that the program computes with."""

import math
import re
from functools import cache
from importlib.resources import as_file, files

import pint

# Pint on its own reads «9 5/8 in» as 9 · 5 / 8 in, «5″» as a bare 5 and «Nm» as a unit of yarn, each
# without a word. So a quantity is one number and one plain product of units; nothing else reaches Pint.
_QUANTITY = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(1/min|\D.*)?", re.DOTALL)
_UNIT = re.compile(r"(?:[A-Za-zµμ_]+(?:(?:\^|\*\*)-?[0-9](?![0-9]))?|[*/()\s])+")
_FRACTION = re.compile(r"([0-9]+\s+|)([0-9]{1,3})/([1-9][0-9]{0,2})\s*([^0-9]*)")

# As typed on a rig, and as Pint calls it: raised figures, dots and hyphens between units, inch marks, «kNm».
# Of «ft-lb» the pound is one of force, and «1/min» alone are turns.
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_SPELLINGS = (
    (re.compile(r"[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+"), lambda found: "^" + found[0].translate(_RAISED)),
    (re.compile(r"\b(k?)ft[-.·⋅]lbs?\b"), lambda found: f"{found[1]}ft*lbf"),
    (re.compile(r"^\s*(?:[1r]/min|min\^-1)\s*$"), lambda _: "rpm"),
    (re.compile(r"[·⋅×∙•]|(?<=[A-Za-z])[-.](?=[A-Za-z])"), lambda _: "*"),
    (re.compile(r"°"), lambda _: "degree"),
    (re.compile(r"[\"″]"), lambda _: "inch"),
    (re.compile(r"\b([kM]?)Nm\b"), lambda found: f"{found[1]}N*m"),
)

# Pint holds an angle to be a pure number, so that a frequency and an angular speed would convert
# into one another without the factor 2π. The two families are told apart by name.
_FREQUENCY = ("hertz",)
_ANGULAR = ("radian", "revolution", "turn", "degree")


@cache
def registry() -> "pint.UnitRegistry[float]":
    """The one registry of units: those of a rig."""
    with as_file(files("vsensor") / "rig_units.txt") as rig_units:
        return pint.UnitRegistry(rig_units)


def to_si(value: object, unit: str) -> float:
    """Read a quantity: text with a unit, or a bare number that is in `unit` already.

    Raises ValueError with a sentence that says what was wrong and shows what would be right.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ValueError(f'{value!r} is no quantity: write a number in {unit}, or text such as "1 {unit}"')
    try:
        number = _parse(value.strip(), unit) if isinstance(value, str) else float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{value!r} is not finite")
    return number


@cache
def factor(unit: str, other: str) -> float:
    """How many `other` make one `unit`; ValueError where the two do not measure the same."""
    return to_si(f"1 {unit}", other)


def _parse(text: str, unit: str) -> float:
    _refuse_ambiguous(text)
    found = _QUANTITY.fullmatch(text)
    if not found:
        raise ValueError(f'{text!r} is no quantity: write for example "1 {unit}"')
    number = float(found[1])
    if not found[2]:
        return number
    target = registry().Unit(_plain(unit))
    given = _unit(found[2], text, unit)
    if given.dimensionality != target.dimensionality or _mixes_turns(str(given), str(target)):
        raise ValueError(f'{text!r} does not measure in {unit}: write for example "1 {unit}"')
    return float(registry().Quantity(number, given).to(target).magnitude)


def _refuse_ambiguous(text: str) -> None:
    if "," in text:
        raise ValueError(f"{text!r}: a comma may part thousands or decimals: write a point or nothing")
    if fraction := _FRACTION.fullmatch(text):
        whole, over, under, unit = fraction.groups()
        decimal = int(whole or 0) + int(over) / int(under)
        raise ValueError(f'{text!r}: fractions are not read: write "{decimal:.7g} {_plain(unit)}"')


def _unit(written: str, text: str, unit: str) -> "pint.Unit":
    plain = _plain(written)
    try:
        if not _UNIT.fullmatch(plain):
            raise ValueError(plain)
        return registry().Unit(plain)
    except Exception as error:  # pint raises whatever its tokenizer meets; all mean «not a unit»
        raise ValueError(
            f'{text!r}: {written.strip()!r} is no unit known here: write for example "1 {unit}"'
        ) from error


def _plain(unit: str) -> str:
    for written, meant in _SPELLINGS:
        unit = written.sub(meant, unit)
    return unit


def _mixes_turns(one: str, other: str) -> bool:
    """Whether one is a frequency and the other an angular speed."""

    def either(a: str, b: str) -> bool:
        return any(w in a for w in _FREQUENCY) and any(w in b for w in _ANGULAR)

    return either(one, other) or either(other, one)
