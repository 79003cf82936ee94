"""The rig as frozen, validated values in SI, read from a TOML file with units."""

import tomllib
from pathlib import Path
from typing import Annotated, Literal, Self

import tomli_w
from pydantic import AfterValidator, Field, ValidationError, model_validator

from vsensor.errors import ConfigError
from vsensor.faults import every_fault
from vsensor.schema import (
    AngularSpeed,
    Bore,
    DataSize,
    Density,
    Endpoint,
    ForceLimit,
    Inertia,
    Length,
    Modulus,
    PositiveTime,
    Processor,
    Rate,
    Ratio,
    SampleRate,
    Share,
    Switch,
    Table,
    Time,
    Torque,
    TorqueLimit,
    TorquePerLength,
    ViscousFriction,
    ViscousFrictionPerLength,
    quantity,
)
from vsensor.well import Station, Wellbore, from_surface


class Component(Table):
    """One part of the string, of constant cross section: drill pipe, collar, stabiliser."""

    name: str = Field(default="pipe", min_length=1)
    length: Length = Field(description='a length such as "1502.54 m"')
    outer_diameter: Length = Field(description='a diameter such as "5 in"')
    inner_diameter: Bore = Field(description='a diameter such as "108.6 mm", or 0 for a solid bar')
    shear_modulus: Modulus = 79.3e9
    density: Density = 7850.0
    viscous_friction: ViscousFrictionPerLength = 0.0
    coulomb_friction: TorquePerLength = 0.0
    static_friction: TorquePerLength = Field(default_factory=lambda given: given["coulomb_friction"])
    tool_joint_diameter: Length = Field(default_factory=lambda given: given["outer_diameter"])
    torsional_strength: TorqueLimit | None = None
    make_up_torque: TorqueLimit | None = None
    tensile_strength: ForceLimit | None = None

    @model_validator(mode="after")
    def _is_a_pipe(self) -> Self:
        if self.inner_diameter >= self.outer_diameter:
            raise ValueError(
                f"inner_diameter {self.inner_diameter:g} m must be smaller than "
                f"outer_diameter {self.outer_diameter:g} m"
            )
        if self.tool_joint_diameter < self.outer_diameter:
            raise ValueError(
                f"tool_joint_diameter {self.tool_joint_diameter:g} m must be at least "
                f"outer_diameter {self.outer_diameter:g} m"
            )
        if self.static_friction < self.coulomb_friction:
            raise ValueError(
                f"static_friction {self.static_friction:g} N·m/m must be at least "
                f"coulomb_friction (kinetic) {self.coulomb_friction:g} N·m/m"
            )
        return self


class TopDrive(Table):
    """The motor and gear that turn the string."""

    inertia: Inertia = 0.0
    gear_ratio: Ratio = Field(default=1.0, description="motor turns for one turn of the string, such as 8.5")
    efficiency: Ratio = Field(default=1.0, le=1, description="a number up to 1, such as 0.95")
    torque_lag: Time = 0.0


class Bit(Table):
    """The bit's inertia and a first guess of the load law between bit and rock."""

    inertia: Inertia = 0.0
    viscous_friction: ViscousFriction = 0.0
    kinetic_torque: Torque = 0.0
    static_torque: Torque = Field(default_factory=lambda given: given["kinetic_torque"])
    stribeck_speed: AngularSpeed = 1.0

    @model_validator(mode="after")
    def _static_holds_more(self) -> Self:
        if self.static_torque < self.kinetic_torque:
            raise ValueError(
                f"static_torque {self.static_torque:g} N·m must be at least "
                f"kinetic_torque {self.kinetic_torque:g} N·m"
            )
        return self


class Measurement(Table):
    """How well the surface channels measure, at the motor, and what is beyond belief, at the string."""

    torque_noise: Torque = 80.0
    speed_noise: Annotated[float, quantity("rad/s"), Field(ge=0)] = 0.015
    torque_limit: TorqueLimit = 200e3
    speed_limit: AngularSpeed = 60.0
    max_gap: PositiveTime = 0.25
    restart_gap: PositiveTime = 2.0

    @model_validator(mode="after")
    def _gaps_in_order(self) -> Self:
        if self.restart_gap <= self.max_gap:
            raise ValueError(f"restart_gap {self.restart_gap:g} s must exceed max_gap {self.max_gap:g} s")
        return self


class EstimatorSettings(Table):
    """What is traded: lag against noise, section length against work."""

    lag: PositiveTime = Field(default=0.5, le=10, description='a time up to 10 s, such as "0.5 s"')
    horizon: PositiveTime | None = Field(default=None, description='a time such as "0.8 s"')
    section_length: Length = 300.0
    learn: bool = True
    severity_window: PositiveTime = 20.0


class Tuning(Table):
    """How far the configuration may be from the truth, one standard deviation, most as a share of each.

    The stated deviations count with it. Where `enabled`, the record itself corrects them, by no
    more than three of these.
    """

    enabled: Switch = True
    delay: Share = Field(default=0.01, description="a share such as 0.01")
    inertia: Share = Field(default=0.05, description="a share such as 0.05")
    friction: Share = Field(default=0.15, description="a share such as 0.15")
    torque_offset: Torque = Field(default=0.0, description='a torque such as "200 N*m"')


class DepthSettings(Table):
    """How the depths of bit and hole are read."""

    stand: Length = Field(default=28.5, description='a length such as "28.5 m"')
    off_bottom: Length = Field(default=0.5, description='a height such as "0.5 m"')


class Loop(Table):
    """The fixed-step loop, and what the system is asked for so that it wakes on time.

    With `prefer` it runs with what it is granted, with `require` only with all of it.
    """

    rate: Rate = Field(default=100.0, description='a rate from "1 Hz" to "5 kHz"')
    realtime: Literal["off", "prefer", "require"] = "off"
    priority: int = Field(default=40, ge=1, le=98, strict=True, description="a number from 1 to 98")
    processors: tuple[Processor, ...] = Field(default=(), description="numbers from 0 on, such as [1]")

    @model_validator(mode="after")
    def _processors_are_asked_for(self) -> Self:
        if self.processors and self.realtime == "off":
            raise ValueError(
                'processors are taken only with realtime = "prefer" or "require": write one of them'
            )
        return self


_ENDPOINTS = 'endpoints such as ["tcp/127.0.0.1:7447"]'


class Bus(Table):
    """How the daemon and its clients find one another over Zenoh."""

    prefix: str = Field(
        default="rigs/{rig}",
        pattern=r"^[^/*$#?@\s][^/*$#?\s]*(?:/[^/*$#?@\s][^/*$#?\s]*)*$",
        description='words parted by single "/", without spaces or any of * $ # ?, such as "rigs/{rig}"',
    )
    listen: tuple[Endpoint, ...] = Field(default=("tcp/127.0.0.1:7447",), description=_ENDPOINTS)
    connect: tuple[Endpoint, ...] = Field(default=(), description=_ENDPOINTS)
    max_rate: SampleRate = Field(default=5e3, description='a rate such as "5 kHz"')
    multicast_scouting: Switch = False
    zenoh_config: Path | None = None
    client_zenoh_config: Path | None = None
    user: str | None = Field(default=None, min_length=1)
    password_file: Path | None = None


class Recording(Table):
    """Whether and where sessions are written, how long each is, and how long they are kept; 0 is no limit."""

    enabled: Switch = True
    folder: Path = Path("recordings")
    compression: Literal["zstd", "lz4", "none"] = "zstd"
    split_every: Time = Field(default=3600.0, description='a time such as "1 h", or 0')
    split_size: DataSize = Field(default=1e9, description='a size such as "1 GB", or 0')
    keep_for: Time = Field(default=0.0, description='a time such as "90 days", or 0')
    keep_size: DataSize = Field(default=0.0, description='a size such as "50 GB", or 0')
    keep_free: DataSize = Field(default=500e6, description='a size such as "500 MB", or 0')
    memory: Time = Field(default=300.0, le=3600, description='a time up to 1 h, such as "5 min", or 0')


SpeedUnit = Literal["rpm", "rad/s"]
TorqueUnit = Literal["kN*m", "N*m", "kft*lbf"]


class KeptState(Table):
    """Whether and where what was learned is kept from one start to the next."""

    enabled: Switch = True
    folder: Path = Path("state")


class Metrics(Table):
    """Where health is served to Prometheus and to probes."""

    enabled: Switch = False
    host: str = Field(default="127.0.0.1", min_length=1)
    port: int = Field(default=9464, ge=1, le=65535, strict=True, description="a number from 1 to 65535")


class View(Table):
    """How the live view shows the rig."""

    history: PositiveTime = Field(default=30.0, description='a time such as "30 s"')
    speed_unit: SpeedUnit = "rpm"
    torque_unit: TorqueUnit = "kN*m"


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


def load(path: Path) -> Rig:
    """Read a configuration file; ConfigError tells every fault of it at once, each with its path."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read as a text file: {error}") from error
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
