"""A recorded configuration with some values changed, and what is changed in it."""

import re
import tomllib
from collections.abc import Sequence
from typing import Any

import tomli_w

from vsensor.config import Rig, differences, loads
from vsensor.errors import ConfigError

_OUTSIDE = ("rig.", "bus.", "recording.", "view.")
"""What has no part in the estimates; of the loop, only its rate has."""
_STEP = re.compile(r"([A-Za-z_]\w*)(?:\[(\d+)\])?")


def overridden(rig: Rig, settings: Sequence[str], source: str) -> Rig:
    """The rig with KEY=VALUE applied, such as top_drive.inertia="3000 kg*m^2" or string[2].length=1500.

    Raises ConfigError that names what cannot be set.
    """
    data = rig.model_dump(mode="json", exclude_none=True)
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not equals:
            raise ConfigError(f'--set {setting}: write KEY=VALUE, such as top_drive.inertia="3000 kg*m^2"')
        _put(data, key.strip(), _value(value.strip()))
    return loads(tomli_w.dumps(data), source) if settings else rig


def changed(before: Rig, after: Rig) -> list[str]:
    """Each value that differs and has a part in the estimates, as `key: before → after`."""
    return [
        f"{key}: {_said(was)} → {_said(is_now)}"
        for key, (was, is_now) in differences(before, after).items()
        if _counts(key)
    ]


def _counts(key: str) -> bool:
    return not key.startswith((*_OUTSIDE, "loop.")) or key == "loop.rate"


def _said(value: Any) -> str:
    return "none" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:  # a quantity without its quotes, as shells leave it
        return text


def _put(data: Any, key: str, value: Any) -> None:
    *way, last = _steps(key)
    place, path = data, ""
    for step in way:
        _refuse_misfit(place, step, key, path)
        place = place.setdefault(step, {}) if isinstance(step, str) else place[step]
        path = f"{path}[{step + 1}]" if isinstance(step, int) else f"{path}.{step}".lstrip(".")
    _refuse_misfit(place, last, key, path)
    place[last] = value


def _refuse_misfit(place: Any, step: str | int, key: str, path: str) -> None:
    """Raise ConfigError where what stands at `path` has no such part."""
    if isinstance(step, int):
        if not isinstance(place, list) or not 0 <= step < len(place):
            many = f"there are {len(place)}" if isinstance(place, list) else "this is no list"
            raise ConfigError(f"--set {key}: no number {step + 1}: {many}")
    elif isinstance(place, list):
        part = f"{path}[1].{step}" if place and isinstance(place[0], dict) else f"{path}[1]"
        raise ConfigError(f"--set {key}: {path} is a list of {len(place)}: write such as {part}")
    elif not isinstance(place, dict):
        raise ConfigError(f"--set {key}: {path} is a value and has no {step}: write {path}=VALUE")


def _steps(key: str) -> list[str | int]:
    steps: list[str | int] = []
    for part in key.split("."):
        found = _STEP.fullmatch(part)
        if not found:
            raise ConfigError(f"--set {key}: {part!r} is no key: write such as string[2].length")
        steps.append(found[1])
        if found[2]:
            steps.append(int(found[2]) - 1)
    return steps
