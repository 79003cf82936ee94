"""What a configuration is made of: its tables, and what their values measure."""

import math
import re
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from vsensor.units import to_si


class Table(BaseModel):
    """One table: frozen, and without a key that is not known here."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def quantity(unit: str) -> BeforeValidator:
    """Read text with a unit, or a bare number in `unit`, which is SI."""
    return BeforeValidator(lambda value: to_si(value, unit))


def _without_secret(endpoint: object) -> object:
    """Zenoh takes a key in an endpoint too; from there it would get into sessions and messages."""
    if isinstance(endpoint, str) and re.search(r"_(?:raw|base64)=", endpoint):
        raise ValueError("an endpoint that holds a key itself: name the key's file, in zenoh_config")
    return endpoint


def _without_nul(path: object) -> object:
    if "\0" in str(path):
        raise ValueError(f"{str(path)!r} is no path: no file's name holds a zero")
    return path


Place = Annotated[Path, BeforeValidator(_without_nul)]
Length = Annotated[float, quantity("m"), Field(gt=0)]
Bore = Annotated[float, quantity("m"), Field(ge=0)]
Modulus = Annotated[float, quantity("Pa"), Field(gt=0)]
Density = Annotated[float, quantity("kg/m^3"), Field(gt=0)]
Inertia = Annotated[float, quantity("kg*m^2"), Field(ge=0)]
Torque = Annotated[float, quantity("N*m"), Field(ge=0)]
AngularSpeed = Annotated[float, quantity("rad/s"), Field(gt=0)]
ViscousFriction = Annotated[float, quantity("N*m*s/rad"), Field(ge=0)]
ViscousFrictionPerLength = Annotated[float, quantity("N*m*s/rad/m"), Field(ge=0)]
TorquePerLength = Annotated[float, quantity("N*m/m"), Field(ge=0)]
Depth = Annotated[float, quantity("m"), Field(ge=0)]
Inclination = Annotated[float, quantity("rad"), Field(ge=0, le=math.pi)]
Azimuth = Annotated[float, quantity("rad"), Field(ge=-2 * math.pi, le=2 * math.pi)]
TorqueLimit = Annotated[float, quantity("N*m"), Field(gt=0)]
ForceLimit = Annotated[float, quantity("N"), Field(gt=0)]
Force = Annotated[float, quantity("N"), Field(ge=0)]
Time = Annotated[float, quantity("s"), Field(ge=0)]
DataSize = Annotated[float, quantity("B"), Field(ge=0)]
PositiveTime = Annotated[float, quantity("s"), Field(gt=0)]
Processor = Annotated[int, Field(ge=0, le=4095, strict=True)]
Rate = Annotated[float, quantity("Hz"), Field(ge=1, le=5000)]
SampleRate = Annotated[float, quantity("Hz"), Field(gt=0)]
Endpoint = Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]*/\S+$"), BeforeValidator(_without_secret)]
Switch = Annotated[bool, Field(strict=True)]
Share = Annotated[float, Field(gt=0, le=0.3, strict=True, allow_inf_nan=False)]
Ratio = Annotated[float, Field(gt=0, strict=True, allow_inf_nan=False)]
FrictionFactor = Annotated[float, Field(ge=0, strict=True, allow_inf_nan=False)]
