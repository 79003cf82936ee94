"""The faults of a configuration, all of them, in sentences that say where, what and what would be right."""

from collections.abc import Mapping
from difflib import get_close_matches
from types import NoneType
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

Location = tuple[int | str, ...]

# Pydantic's kinds of fault in a driller's words; what is not here keeps Pydantic's own sentence.
_SENTENCES = {
    "missing": "is missing",
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be less than {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "finite_number": "must be finite",
    "float_type": "must be a number, without quotes",
    "int_type": "must be a whole number, without quotes",
    "bool_type": "must be true or false, without quotes",
    "string_type": "must be text in quotes",
    "string_too_short": "must not be empty",
    "string_too_long": "must be no longer than {max_length} characters",
    "string_pattern_mismatch": "cannot be used",
    "literal_error": "must be {expected}",
    "tuple_type": "must be a list",
    "too_short": "must not be empty",
    "model_type": "must be a table",
    "path_type": "must be a path in quotes",
}


def every_fault(error: ValidationError, data: Mapping[str, Any], model: type[BaseModel], source: str) -> str:
    """One line for each fault of `data`, the TOML as it was read, that `model` refused."""
    errors = error.errors(include_url=False)
    faults = [_fault(e, data, model) for e in errors if not _follows_on(e, errors)]
    count = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
    return "\n".join([f"{source}: {count}", *(f"  {fault}" for fault in faults)])


def _follows_on(fault: ErrorDetails, faults: list[ErrorDetails]) -> bool:
    """Whether a fault only says that another happened: a list is «too short» once its items are refused."""
    if fault["type"] == "default_factory_not_called":
        return True
    depth = len(fault["loc"])
    return fault["type"] == "too_short" and any(
        len(other["loc"]) > depth and other["loc"][:depth] == fault["loc"] for other in faults
    )


def _fault(fault: ErrorDetails, data: Mapping[str, Any], model: type[BaseModel]) -> str:
    location, kind = fault["loc"], fault["type"]
    path = _path(location)
    if kind == "value_error":  # raised by us, and says it all
        return f"{path}{': ' if path else ''}{fault['msg'].removeprefix('Value error, ')}"
    if kind == "extra_forbidden":
        return f"{path}: no such key: {_known(str(location[-1]), _table(model, location[:-1]))}"
    template = _SENTENCES.get(kind)
    said = template.format(**fault.get("ctx", {})) if template else fault["msg"]
    given = "" if kind == "missing" else f" = {_short(_given(data, location))}"
    right = _field(model, location).description
    return f"{path}{given}: {said}" + (f": write {right}" if right else "")


def _path(location: Location) -> str:
    return "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in location).lstrip(".")


def _known(key: str, table: type[BaseModel]) -> str:
    near = get_close_matches(key, table.model_fields, n=1)
    return f"did you mean {near[0]}?" if near else f"known here are {', '.join(table.model_fields)}"


def _given(data: object, location: Location) -> object:
    """The value as it stands in the file: Pydantic reports «-5 ft» as -1.524."""
    for part in location:
        data = data[part]  # type: ignore[index]  # a location that Pydantic has walked itself
    return data


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _field(model: type[BaseModel], location: Location) -> FieldInfo:
    """The field that a location leads to; of an item of a list, the list."""
    while isinstance(location[-1], int):
        location = location[:-1]
    return _table(model, location[:-1]).model_fields[str(location[-1])]


def _table(model: type[BaseModel], location: Location) -> type[BaseModel]:
    for part in location:
        if isinstance(part, str):
            model = _inner(model.model_fields[part].annotation)
    return model


def _inner(annotation: Any) -> type[BaseModel]:
    """The table behind `Table`, `tuple[Table, ...]` or `Table | None`."""
    inside = [kind for kind in get_args(annotation) if kind not in (Ellipsis, NoneType)]
    table: type[BaseModel] = inside[0] if inside else annotation
    return table
