"""What a file calls the columns of a surface table, and how each is told."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

from vsensor.errors import ConfigError
from vsensor.messages import SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH
from vsensor.tables.source import PLAIN_HEAD, Head
from vsensor.tables.times import IN_SECONDS, TimeForm
from vsensor.units import factor

_EXACT_TIME = "time_ns"
"""Seconds as doubles, which stand beside it in tables of ours, know a time since 1970 to 119 ns."""
DEPTH_COLUMNS = {SURFACE_BIT_DEPTH: "bit_depth_m", SURFACE_HOLE_DEPTH: "hole_depth_m"}
"""What tables of ours call the depths, by topic."""


@dataclass(frozen=True)
class Layout:
    """What a file calls the columns of a surface table, and how each is told; date and depths may be none.

    A time without a name is `time_ns` where there is one, else `time_s`. A unit that is not told is that of a
    line of units, else the SI's. `nulls` are numbers that stand for no value.
    """

    time: str = ""
    torque: str = "motor_torque_nm"
    speed: str = "motor_speed_rad_s"
    date: str = ""
    form: TimeForm = IN_SECONDS
    torque_unit: str = ""
    speed_unit: str = ""
    bit_depth: str = ""
    hole_depth: str = ""
    depth_unit: str = ""
    nulls: tuple[float, ...] = ()
    head: Head = PLAIN_HEAD

    @property
    def depths(self) -> Mapping[str, str]:
        """The columns of depths that there are, by topic."""
        depths = {SURFACE_BIT_DEPTH: self.bit_depth, SURFACE_HOLE_DEPTH: self.hole_depth}
        return {topic: column for topic, column in depths.items() if column}

    @property
    def columns(self) -> Mapping[str, str]:
        """The columns that are read, each with the option that names it; ConfigError where two name one."""
        named = {
            "--time-column": self.time,
            "--torque-column": self.torque,
            "--speed-column": self.speed,
            "--date-column": self.date,
            "--bit-depth-column": self.bit_depth,
            "--hole-depth-column": self.hole_depth,
        }
        columns: dict[str, str] = {}
        for option, column in named.items():
            if column in columns:
                raise ConfigError(f"{columns[column]} and {option} both name {column!r}")
            if column:
                columns[column] = option
        return columns

    def among(self, present: Sequence[str], *, depths: bool) -> Self:
        """The same in a file with these columns: which of those without a name it has, depths if wanted."""
        named = self
        if depths:
            bit, hole = (column if column in present else "" for column in DEPTH_COLUMNS.values())
            named = replace(self, bit_depth=self.bit_depth or bit, hole_depth=self.hole_depth or hole)
        if self.time or self.date or self.form != IN_SECONDS or _EXACT_TIME not in present:
            return replace(named, time=self.time or "time_s")
        return replace(named, time=_EXACT_TIME, form=TimeForm("ns"))

    def told_by(self, units: Mapping[str, str]) -> Self:
        """The same, with the units of a file's own line where no other is told."""
        depths = {units[column] for column in self.depths.values() if column in units}
        if len(depths) > 1 and not self.depth_unit:
            raise ConfigError(
                f"depths are in {' and in '.join(sorted(depths))}: --depth-unit tells one for both"
            )
        return replace(
            self,
            torque_unit=self.torque_unit or units.get(self.torque, ""),
            speed_unit=self.speed_unit or units.get(self.speed, ""),
            depth_unit=self.depth_unit or next(iter(depths), ""),
            form=self.form.told_by(units.get(self.time, "")),
        )

    def scales(self) -> tuple[float, float, float]:
        """How many SI units one of torque, of speed and of depth is; ConfigError for what is no unit."""
        return (
            _scale("motor_torque_nm", self.torque_unit, "N*m"),
            _scale("motor_speed_rad_s", self.speed_unit, "rad/s"),
            _scale("a depth", self.depth_unit, "m"),
        )


PLAIN = Layout()


def _scale(column: str, unit: str, si: str) -> float:
    try:
        return factor(unit or si, si)
    except ValueError as error:
        raise ConfigError(f"{unit!r} is no unit for {column}: write for example {si!r}") from error
