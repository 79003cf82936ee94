"""What the sensor has learned, as one message: load law, corrections of the configuration, string length.

It is worth something only to a sensor of the same string: all of the configuration that the estimator
heeds is noted with it.
"""

import json
import time
from typing import Any

import numpy as np

from vsensor import __version__
from vsensor.checkpoint import array_of
from vsensor.config import Rig
from vsensor.depth import DEEPEST_M
from vsensor.estimator.estimator import Estimator
from vsensor.intake import Intake
from vsensor.messages import Array, Learned
from vsensor.saved import Saved

HEEDED = ("string", "survey", "wellbore", "top_drive", "bit", "measurement", "estimator", "tuning", "depth")
"""Tables of a configuration that the estimator heeds, beside the loop's rate."""


def learned(rig: Rig, intake: Intake, estimator: Estimator) -> Learned:
    """What `begin_with` takes; `rig` as configured."""
    return Learned(
        rig=rig.rig.name,
        version=__version__,
        saved_ns=time.time_ns(),
        configuration=json.dumps(_heeded(rig)),
        string_length_m=intake.depths.length,
        arrays=[
            Array(name=name, dtype=array.dtype.str, shape=array.shape, data=array.tobytes())
            for name, array in estimator.learned().items()
        ],
    )


def begin_with(before: Learned, rig: Rig, intake: Intake, estimator: Estimator) -> None:
    """Begin with what was learned before. Raises ValueError where it does not fit, and changes nothing."""
    if before.rig != rig.rig.name:
        raise ValueError(f"it is of rig {before.rig!r}")
    if changed := _changed(before.configuration, _heeded(rig)):
        raise ValueError(f"the configuration has changed since, in {', '.join(changed)}")
    if before.version != __version__:
        raise ValueError(f"it is of version {before.version!r}, this is {__version__}")
    arrays = {described.name: array_of(described) for described in before.arrays}
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise ValueError(f"{name} is not finite")
    if not 0 < before.string_length_m <= max(DEEPEST_M, intake.depths.length):
        raise ValueError(f"a string of {before.string_length_m:g} m is none")
    estimator.begin_with(arrays)
    # Pipe that was added behind the last tick is taken up at the first.
    length = sum(part.length for part in estimator.string)
    longer = max(round(before.string_length_m - length, 6), 1.0 - estimator.string[0].length)
    depths = {**intake.depths.save(), "length": length + longer, "longer": longer}
    intake.depths.restore(Saved(depths, "depths"))


def _heeded(rig: Rig) -> dict[str, Any]:
    tables = rig.model_dump(mode="json", include=set(HEEDED))
    return {**tables, "loop.rate": rig.loop.rate}


def _changed(before: str, now: dict[str, Any]) -> list[str]:
    try:
        tables = json.loads(before)
        return [name for name, table in now.items() if tables.get(name) != table]
    except (ValueError, AttributeError) as error:
        raise ValueError(f"its configuration cannot be read: {error}") from error
