"""What is installed with us: pinned, as it was tested, and under licences that ask nothing of our users."""

import pkgutil
import re
import subprocess
import sys
from importlib.metadata import Distribution, distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import vsensor

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


BLOCKED = "import sys; sys.modules.update(dict.fromkeys(('rerun', 'PIL', 'matplotlib', 'scipy', 'plotly')))\n"
WITH_EXTRAS = (
    *("vsensor.view", "vsensor.paper", "vsensor.report", "vsensor.recording.picture"),
    *("vsensor.bench.view", "vsensor.bench.seen"),
)


def without_extras(program: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", BLOCKED + program], capture_output=True, text=True, check=False
    )


def test_a_sensor_needs_no_extra() -> None:
    """What the view, the paper and the report need may be missing: all else can be imported."""
    found = (module.name for module in pkgutil.walk_packages(vsensor.__path__, "vsensor."))
    names = [name for name in found if not name.startswith(WITH_EXTRAS) and not name.endswith("__main__")]
    assert "vsensor.service.daemon" in names
    done = without_extras(f"import importlib\nfor name in {names}: importlib.import_module(name)")
    assert (done.returncode, done.stderr) == (0, "")


def test_a_view_without_its_extra_says_what_to_install() -> None:
    done = without_extras("from vsensor.cli.main import app; app(['view'])")
    assert done.returncode == 1
    assert "an extra: pip install 'vsensor[view]'" in done.stderr
    assert "Traceback" not in done.stderr
