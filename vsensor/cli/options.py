"""Options that several commands share, held to the rules of a configuration."""

from typing import Any, TypeVar

import typer
from pydantic import BaseModel, ValidationError

from vsensor.config import Bus, Rig
from vsensor.config.faults import every_fault
from vsensor.errors import ConfigError

NULL: Any = typer.Option(metavar="VALUE", help="A number in the table that stands for no value; repeatable.")
"""What it is in a command that reads a table."""

Model = TypeVar("Model", bound=BaseModel)


def connected(bus: Bus, endpoint: str) -> Bus:
    """The bus as reached by `--connect`; ConfigError for what is no endpoint."""
    return _checked(Bus, {**dict(bus), "connect": [endpoint]}, "--connect") if endpoint else bus


def rig_name(name: str, source: str = "--rig") -> str:
    """A rig's name as `source` tells it; ConfigError for what cannot be one."""
    return _checked(Rig.Name, {"name": name}, source).name


def _checked(model: type[Model], data: dict[str, Any], source: str) -> Model:
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise ConfigError(every_fault(error, data, model, source)) from error
