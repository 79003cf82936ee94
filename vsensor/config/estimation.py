"""What is asked of the estimator, and how far the configuration itself may be from the truth."""

from pydantic import Field

from vsensor.config.schema import (
    Length,
    PositiveTime,
    Share,
    Switch,
    Table,
    Torque,
)


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
    impedance: Share = Field(default=0.02, description="a share such as 0.02")
    inertia: Share = Field(default=0.05, description="a share such as 0.05")
    friction: Share = Field(default=0.25, description="a share such as 0.25")
    torque_offset: Torque = Field(default=0.0, description='a torque such as "200 N*m"')


class DepthSettings(Table):
    """How the depths of bit and hole are read."""

    stand: Length = Field(default=28.5, description='a length such as "28.5 m"')
    off_bottom: Length = Field(default=0.5, description='a height such as "0.5 m"')
