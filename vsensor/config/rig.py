"""The rig as frozen, validated values in SI, read from a TOML file with units."""

import math
import tomllib
from pathlib import Path
from typing import Annotated, Self

import tomli_w
from pydantic import AfterValidator, Field, ValidationError, model_validator

from vsensor.config.estimation import DepthSettings, EstimatorSettings, Tuning
from vsensor.config.faults import every_fault
from vsensor.config.hardware import Bit, Component, Measurement, TopDrive
from vsensor.config.schema import (
    Table,
)
from vsensor.config.service import Bus, KeptState, Loop, Metrics, Recording, View
from vsensor.config.well import Station, Wellbore, from_surface
from vsensor.errors import ConfigError

LONGEST_TRAVEL_S = 20.0
"""Of waves from top to bit: the observer's gains are worked out over two minutes, the echo must fit in."""


class Rig(Table):
    """A whole configuration. Lengths in m, torques in N·m, speeds in rad/s, times in s."""

    class Name(Table):
        """Which rig this is; part of every key on the bus."""

        name: str = Field(
            pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$",
            max_length=64,
            description='letters, digits and . _ - between them, such as "well-b"',
        )

    rig: Name = Field(description='[rig] with a name, such as name = "well-b"')
    string: tuple[Component, ...] = Field(
        min_length=1, description="one [[string]] table for each component, from the top drive down"
    )
    survey: Annotated[tuple[Station, ...], AfterValidator(from_surface)] = ()
    wellbore: Wellbore | None = None
    top_drive: TopDrive = TopDrive()
    bit: Bit = Bit()
    measurement: Measurement = Measurement()
    estimator: EstimatorSettings = EstimatorSettings()
    tuning: Tuning = Tuning()
    depth: DepthSettings = DepthSettings()
    loop: Loop = Loop()
    bus: Bus = Bus()
    recording: Recording = Recording()
    state: KeptState = KeptState()
    metrics: Metrics = Metrics()
    view: View = View()

    @model_validator(mode="after")
    def _wall_told_once(self) -> Self:
        if bool(self.survey) != bool(self.wellbore):
            missing = "[wellbore] with mud_density" if self.survey else "[[survey]] tables"
            raise ValueError(f"survey and wellbore need one another: write {missing} too, or leave out both")
        if self.wellbore:
            for number, part in enumerate(self.string, 1):
                _hangs_in_mud(f'string[{number}] "{part.name}"', part, self.wellbore.mud_density)
        return self

    @model_validator(mode="after")
    def _bit_can_be_heard(self) -> Self:
        seconds = sum(part.length * math.sqrt(part.density / part.shear_modulus) for part in self.string)
        if seconds > LONGEST_TRAVEL_S:
            raise ValueError(
                f"string: a wave takes {seconds:.3g} s to reach the bit, and none is told of that takes "
                f"more than {LONGEST_TRAVEL_S:g} s, three times the deepest well's: are the units of length, "
                "shear_modulus and density right?"
            )
        return self

    @property
    def prefix(self) -> str:
        """The start of every key on the bus."""
        return self.bus.prefix.replace("{rig}", self.rig.name)


def _hangs_in_mud(where: str, part: Component, mud_density: float) -> None:
    if part.static_friction:
        raise ValueError(
            f"{where}: coulomb_friction and static_friction are an alternative to a survey, "
            "which tells the wall's friction itself: leave out the one or the other"
        )
    if part.density <= mud_density:
        raise ValueError(
            f"wellbore.mud_density {mud_density:g} kg/m³ must be below the {part.density:g} kg/m³ of {where}"
        )


MOST_BYTES = 1 << 20
"""A survey of a thousand stations takes a tenth of it: what is larger was named by mistake."""


def load(path: Path) -> Rig:
    """Read a configuration file; ConfigError tells every fault of it at once, each with its path."""
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise ConfigError(f"{path}: is larger than {MOST_BYTES >> 20} MiB, as no configuration is")
        text = content.decode("utf-8-sig")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise ConfigError(f"{path}, line {line}: is not UTF-8: save it as UTF-8 text") from error
    return loads(text, str(path))


def loads(text: str, source: str) -> Rig:
    """Read a configuration from text; `source` names it in errors."""
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"{source}: not valid TOML: {error}") from error
    try:
        return Rig.model_validate(data)
    except ValidationError as error:
        raise ConfigError(every_fault(error, data, Rig, source)) from error


def effective_toml(rig: Rig) -> str:
    """The whole configuration as TOML, defaults filled in, numbers in SI: reading it gives `rig` exactly.

    It goes into each session, so that what was computed can be computed again.
    """
    return tomli_w.dumps(rig.model_dump(mode="json", exclude_none=True))
