"""Cases whose truth is known, from folders outside the repository: read, run and scored."""

import csv
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from vsensor.config import Rig
from vsensor.grid import NS
from vsensor.intake.arrivals import Feed, Inputs
from vsensor.offline import Offline
from vsensor.tables import SurfaceSamples, SurfaceTable, read_surface

Columns = Mapping[str, NDArray[np.float64]]
Learned = Mapping[str, NDArray[np.generic]]
"""What an estimator has learned, as it gives it."""


def folder(variable: str) -> Path:
    """A data folder outside the repository; where there is none, the test is skipped and says so."""
    place = os.environ.get(variable)
    if not place:
        pytest.skip(f"{variable} names no folder: this data is not part of the repository")
    return Path(place)


def reference_rig(case: Path) -> Rig:
    """The configuration of a reference case, from its description."""
    told = json.loads(case.read_text())
    viscous, kinetic, static, stribeck, _ = told["bit"]["law"]
    noise = told.get("measure", {"torque_sd": 80.0, "speed_sd": 0.015, "vfd_lag": 0.0})
    return Rig.model_validate(
        {
            "rig": {"name": case.stem},
            "string": [
                {
                    "name": part["name"],
                    "length": part["length"],
                    "outer_diameter": 2 * part["ro"],
                    "inner_diameter": 2 * part["ri"],
                    "density": part["rho"],
                    "shear_modulus": part["G"],
                    "viscous_friction": part.get("c", 0.0),
                    "coulomb_friction": part.get("fd", part.get("fs", 0.0)),
                    "static_friction": part.get("fs", 0.0),
                }
                for part in told["string"]
            ],
            "top_drive": {"inertia": told["top_drive"]["inertia"], "torque_lag": noise["vfd_lag"]},
            "bit": {
                "inertia": told["bit"]["inertia"],
                "viscous_friction": viscous,
                "kinetic_torque": kinetic,
                "static_torque": static,
                "stribeck_speed": stribeck,
            },
            "measurement": {"torque_noise": noise["torque_sd"], "speed_noise": noise["speed_sd"]},
        }
    )


class Run(NamedTuple):
    """What the sensor made of a surface table."""

    told: Columns
    """The estimates table."""
    tuning: NDArray[np.float64]
    """What it had corrected in the end: shares of delay, inertia and friction, and the offset, N·m."""


class _Told(Offline):
    """A sensor that knows what one learned before it, and is told until when the bit is off bottom."""

    def __init__(self, rig: Rig, off_bottom_until_s: float, learned: Learned | None) -> None:
        super().__init__(rig)
        self._until_s = off_bottom_until_s
        if learned is not None:
            self._estimator.begin_with(learned)

    def _inputs(self, feed: Feed) -> Iterator[Inputs]:
        for given in super()._inputs(feed):
            yield given._replace(off_bottom=given.time_ns < self._until_s * NS)


def run(
    rig: Rig,
    surface: Path,
    off_bottom_until_s: float = 0.0,
    rest_s: float = 0.0,
    torque_scale: float = 1.0,
    learned: Learned | None = None,
) -> Run:
    """Run a surface table through the sensor, `rest_s` seconds of rest put before it."""
    sensor = _Told(rig, off_bottom_until_s, learned)
    chunks = list(
        sensor.estimates(
            SurfaceSamples().of(_after_rest(read_surface(surface), rest_s, rig.loop.rate, torque_scale))
        )
    )
    told = {name: np.concatenate([np.asarray(chunk[name]) for chunk in chunks]) for name in chunks[0]}
    return Run(told, sensor.tuning)


def _after_rest(measured: SurfaceTable, rest_s: float, rate: float, scale: float) -> SurfaceTable:
    rest = np.arange(round(rest_s * rate)) / rate
    return SurfaceTable.at_seconds(
        time_s=np.append(rest, measured.time_s + rest_s),
        torque=np.append(0 * rest, scale * measured.motor_torque_nm),
        speed=np.append(0 * rest, measured.motor_speed_rad_s),
    )


def estimated(rig: Rig, surface: Path, rest_s: float = 0.0, torque_scale: float = 1.0) -> Columns:
    """The estimates table of a surface table that `rest_s` seconds of rest are put before."""
    return run(rig, surface, rest_s=rest_s, torque_scale=torque_scale).told


def table(path: Path) -> Columns:
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    return {name: np.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(rows[0])}


def midpoints(when: NDArray[np.float64], speed: NDArray[np.float64], truth: Columns) -> tuple[float, float]:
    """Rms error and correlation of the midpoints of least and greatest bit speed in each half second.

    The downhole clock of the field record is unknown by up to half a second: the best offset counts.
    """
    return min(_midpoints(when, speed, truth, offset) for offset in np.arange(-0.5, 0.501, 0.05))


def _midpoints(
    when: NDArray[np.float64], speed: NDArray[np.float64], truth: Columns, offset: float
) -> tuple[float, float]:
    """Rms error and correlation for one guess of the offset between the two clocks."""
    centre = truth["time_s"] + offset
    low, high = np.searchsorted(when, centre - 0.25), np.searchsorted(when, centre + 0.25)
    use = (high - low > 5) & (truth["time_s"] >= 10) & (centre + 0.25 <= when[-1])
    middle = [(speed[a:b].min() + speed[a:b].max()) / 2 for a, b in zip(low[use], high[use], strict=True)]
    true = (truth["bit_speed_min_rad_s"] + truth["bit_speed_max_rad_s"])[use] / 2
    error = np.array(middle) - true
    return float(np.sqrt(np.mean(error**2))), float(np.corrcoef(middle, true)[0, 1])
