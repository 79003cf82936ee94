"""How the daemon runs, speaks, records and is watched."""

from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from vsensor.config.schema import (
    DataSize,
    Endpoint,
    Place,
    PositiveTime,
    Processor,
    Rate,
    SampleRate,
    Switch,
    Table,
    Time,
)


class Loop(Table):
    """The fixed-step loop, and what the system is asked for so that it wakes on time.

    With `prefer` it runs with what it is granted, with `require` only with all of it.
    """

    rate: Rate = Field(default=100.0, description='a rate from "1 Hz" to "5 kHz"')
    realtime: Literal["off", "prefer", "require"] = "off"
    priority: int = Field(default=40, ge=1, le=98, strict=True, description="a number from 1 to 98")
    processors: tuple[Processor, ...] = Field(default=(), description="numbers from 0 on, such as [1]")
    stay_awake: Switch = False

    @model_validator(mode="after")
    def _real_time_is_asked_for(self) -> Self:
        asked = [key for key in ("processors", "stay_awake") if getattr(self, key)]
        if asked and self.realtime == "off":
            raise ValueError(
                f'{" and ".join(asked)}: only with realtime = "prefer" or "require": write one of them'
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
    zenoh_config: Place | None = None
    client_zenoh_config: Place | None = None
    user: str | None = Field(default=None, min_length=1)
    password_file: Place | None = None


class Recording(Table):
    """Whether and where sessions are written, how long each is, and how long they are kept; 0 is no limit."""

    enabled: Switch = True
    folder: Place = Path("recordings")
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
    folder: Place = Path("state")


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
