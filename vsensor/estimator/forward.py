"""The string driven from the top alone: motor torque in, the whole string under a load law out.

This is the paper's own case (Fig. 7: torque measured, speed not) and, under a speed controller, the simulated
rig.
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


class Controller(NamedTuple):
    """A speed controller as the string feels it: proportional and integral, held at the limit."""

    gain: float
    """N·m·s/rad."""
    integral_rate: float
    """What a step adds to the integral for each rad/s of miss, N·m·s/rad."""
    limit: float
    """N·m."""


NONE = Controller(0.0, 0.0, np.inf)


class ForwardLine:
    """A string at rest, then driven by motor torque or by a speed controller."""

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
        self._integral = np.zeros(1)
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
        self._integral[:] = 0.0
        _, *told = self._run(NONE, torques, np.zeros(len(torques)), bit_torque)
        return told[0], told[1], told[2]

    def control(
        self, by: Controller, set_speed: ArrayLike, bit_torque: ArrayLike
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Run n steps of a motor that is to keep this speed of the string's top, rad/s, shape (n,).

        It looks at the speed of the step before. Returns motor torque, and the three of `run`.
        """
        targets = np.ascontiguousarray(set_speed, dtype=np.float64)
        return self._run(by, np.zeros(len(targets)), targets, bit_torque)

    def _run(
        self, by: Controller, torques: Floats, targets: Floats, bit_torque: ArrayLike
    ) -> tuple[Floats, Floats, Floats, Floats]:
        external = np.ascontiguousarray(bit_torque, dtype=np.float64)
        out = np.empty((4, len(torques)))
        _drive(
            self._line,
            self._load,
            self._drive,
            by,
            self._waves,
            self._step,
            torques,
            targets,
            external,
            self._speeds,
            self._balances,
            self._integral,
            self._told,
            out,
        )
        self._step += len(torques)
        return out[0] / self._drive.torque_ratio, out[1] * self._gear, out[2], out[3]


@compiled
def _drive(
    line: Line,
    load: Load,
    drive: Drive,
    by: Controller,
    waves: Floats,
    done: int,
    torques: Floats,
    targets: Floats,
    external: Floats,
    speeds: Floats,
    balances: Floats,
    integral: Floats,
    told: Floats,
    out: Floats,
) -> None:
    mask = mask_of(waves.shape[1])
    z = line.impedance[0]
    for k in range(torques.shape[0]):
        step = done + k
        g, balances[BIT] = march(line, load, waves, step, external[k], speeds, balances[BIT], told, 0)
        miss = targets[k] - speeds[0]
        wanted = drive.torque_ratio * torques[k] + by.gain * miss + integral[0]
        given = max(-by.limit, min(by.limit, wanted))
        if given == wanted:
            integral[0] += by.integral_rate * miss
        w, balances[TOP] = turn_top(line, drive.inertia_rate, given - g, speeds[0], balances[TOP])
        speeds[0] = w
        waves[0, step & mask] = g + 2 * z * w
        out[0, k] = given
        out[1, k] = w
        out[2, k] = told[0, 0]
        out[3, k] = told[1, 0]
