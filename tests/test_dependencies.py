"""What is installed with us: pinned, as it was tested, and under licences that ask nothing of our users."""

import re
from importlib.metadata import Distribution, distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PINS = Path(__file__).parent.parent / "constraints.txt"
PERMISSIVE = re.compile(r"\b(MIT|BSD|Apache|ISC|PSF|0BSD|Zlib|EPL-2\.0)\b")
COPYLEFT = re.compile(r"\b[AL]?GPL")


def pins() -> dict[str, str]:
    lines = (line.split("==") for line in PINS.read_text(encoding="utf-8").splitlines() if "==" in line)
    return {canonicalize_name(name): version for name, version in lines}


def installed_with_us() -> dict[str, Distribution]:
    """All that `pip install vsensor` brings, without extras."""
    found: dict[str, Distribution] = {}
    wanted = ["vsensor"]
    while wanted:
        name = canonicalize_name(wanted.pop())
        if name in found:
            continue
        found[name] = distribution(name)
        needs = (Requirement(text) for text in found[name].requires or [])
        wanted += [need.name for need in needs if need.marker is None or need.marker.evaluate({"extra": ""})]
    del found["vsensor"]
    return found


def licence(of: Distribution) -> str:
    fields = [of.metadata.get_all(field, []) for field in ("License-Expression", "License", "Classifier")]
    return " ".join(text for texts in fields for text in texts if "::" not in text or "License" in text)


@pytest.mark.parametrize("name", sorted(installed_with_us()))
def test_each_is_pinned_and_permissive(name: str) -> None:
    package = installed_with_us()[name]
    assert pins()[name] == package.version
    assert PERMISSIVE.search(licence(package))
    assert not COPYLEFT.search(licence(package))
