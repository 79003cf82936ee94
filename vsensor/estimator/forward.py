"""The string driven from the top alone: motor torque in, the whole string under a load law out.

This is the paper's own case (Fig. 7: torque measured, speed not) and the simulated rig.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vsensor.config import Bit, TopDrive
from vsensor.estimator.line import march, turn_top
from vsensor.estimator.load import Load, load_of
from vsensor.estimator.ring import length_of, mask_of
from vsensor.estimator.sections import Floats, Line
from vsensor.estimator.state import BIT, TOP
from vsensor.jit import compiled


class Drive(NamedTuple):
    """The top drive as the string feels it, at the string's side of the gear."""

    torque_ratio: float
    """String torque for one of motor torque: gear · efficiency."""
    inertia_rate: float
    """2 J / Δt, N·m·s/rad."""


class ForwardLine:
    """A string at rest, then driven by motor torque."""

    def __init__(self, line: Line, drive: TopDrive, bit: Bit, step_s: float) -> None:
        self._line = line
        self._load = load_of(bit, step_s)
        self._drive = Drive(drive.gear_ratio * drive.efficiency, 2 * drive.inertia / step_s)
        self._gear = drive.gear_ratio
        sections = len(line.impedance)
        self._waves = np.zeros((sections, length_of(line.round_trip.max() + 1)))
        self._speeds = np.zeros(sections + 1)
        self._told = np.zeros((2, 1))
        self._step = 0
        self._balances = np.zeros(2)
        self.bit_delay = float(line.round_trip.sum()) / 2 * step_s
        """How long before the top's time the bit is seen, s: one travel time of the string."""

    def set_load(self, bit: Bit) -> None:
        """Let the bit meet another load law from now on; its inertia stays."""
        fresh = load_of(bit, 1.0)
        self._load = fresh._replace(inertia_rate=self._load.inertia_rate)

    def run(self, motor_torque: ArrayLike, bit_torque: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Run n steps of motor torque and of a further torque on the bit, N·m, both of shape (n,).

        Returns motor speed at each step, and bit speed and torque `bit_delay` earlier, all (n,).
        """
        torques = np.ascontiguousarray(motor_torque, dtype=np.float64)
        external = np.ascontiguousarray(bit_torque, dtype=np.float64)
        out = np.empty((3, len(torques)))
        _drive(
            self._line,
            self._load,
            self._drive,
            self._waves,
            self._step,
            torques,
            external,
            self._speeds,
            self._balances,
            self._told,
            out,
        )
        self._step += len(torques)
        return out[0] * self._gear, out[1], out[2]


@compiled
def _drive(
    line: Line,
    load: Load,
    drive: Drive,
    waves: Floats,
    done: int,
    torques: Floats,
    external: Floats,
    speeds: Floats,
    balances: Floats,
    told: Floats,
    out: Floats,
) -> None:
    mask = mask_of(waves.shape[1])
    z = line.impedance[0]
    for k in range(torques.shape[0]):
        step = done + k
        g, balances[BIT] = march(line, load, waves, step, external[k], speeds, balances[BIT], told, 0)
        pull = drive.torque_ratio * torques[k] - g
        w, balances[TOP] = turn_top(line, drive.inertia_rate, pull, speeds[0], balances[TOP])
        speeds[0] = w
        waves[0, step & mask] = g + 2 * z * w
        out[0, k] = w
        out[1, k] = told[0, 0]
        out[2, k] = told[1, 0]
