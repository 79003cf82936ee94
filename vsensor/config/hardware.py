"""What the rig is made of: the string's components, the top drive, the bit, the channels' noise."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from vsensor.config.schema import (
    AngularSpeed,
    Bore,
    Density,
    ForceLimit,
    Inertia,
    Length,
    Modulus,
    PositiveTime,
    Ratio,
    Table,
    Time,
    Torque,
    TorqueLimit,
    TorquePerLength,
    ViscousFriction,
    ViscousFrictionPerLength,
    quantity,
)


class Component(Table):
    """One part of the string, of one cross section but for tool joints: drill pipe, collar, stabiliser."""

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
    tool_joint_bore: Bore = Field(default_factory=lambda given: given["inner_diameter"])
    tool_joint_length: Bore = Field(default=0.0, description='pin and box of a joint, such as "21 in", or 0')
    joint_length: Length = Field(default=9.45, description='from shoulder to shoulder, such as "31 ft"')
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
        if self.tool_joint_bore >= self.tool_joint_diameter:
            raise ValueError(
                f"tool_joint_bore {self.tool_joint_bore:g} m must be smaller than "
                f"tool_joint_diameter {self.tool_joint_diameter:g} m"
            )
        if self.tool_joint_length >= self.joint_length:
            raise ValueError(
                f"tool_joint_length {self.tool_joint_length:g} m must be less than "
                f"joint_length {self.joint_length:g} m"
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
    torque_lag: Time = Field(default=0.0, le=10, description='a time up to 10 s, such as "5 ms"')


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
