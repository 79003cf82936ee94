"""In which keys two configurations differ."""

from collections.abc import Iterator
from typing import Any

from vsensor.config.rig import Rig


def differences(before: Rig, after: Rig) -> dict[str, tuple[Any, Any]]:
    """Each key that differs, such as string[2].length, with both values in SI; None where there is none."""
    was, is_now = (dict(_leaves("", each.model_dump(mode="json"))) for each in (before, after))
    return {
        key: (was.get(key), is_now.get(key))
        for key in dict.fromkeys((*was, *is_now))
        if was.get(key) != is_now.get(key)
    }


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _leaves(f"{path}.{name}" if path else name, inner)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for number, inner in enumerate(value, 1):
            yield from _leaves(f"{path}[{number}]", inner)
    else:
        yield path, value
