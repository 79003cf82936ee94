"""A rig in software: speed controller, motor, string and rock, sampled with the noise of real sensors."""

import math
from typing import NamedTuple

import numpy as np

from vsensor.config import Rig
from vsensor.estimator.forward import ForwardLine
from vsensor.estimator.sections import Floats, cut, steps_per_tick
from vsensor.simulate.scenario import Plan

FINE_STEP_S = 1e-3
"""The simulation steps at least so finely, finer than the estimator, so as to be a test of it."""
SECTION_LENGTH = 100.0
ROCK_MEMORY_S = 0.4
"""Correlation time of the rock's torque."""
RESET_TIME_S = 2.0
"""Integral time of the speed controller."""
TORQUE_RESERVE = 3.0
"""The motor's limit in multiples of the torque that holds the bit and the string's friction."""


class Reading(NamedTuple):
    """What a rig's sensors say at one sample, and what was true at the bit."""

    time_s: float
    motor_torque: float
    motor_speed: float
    bit_time_s: float
    """The truth is for this time: one travel time of the string earlier."""
    bit_speed: float
    bit_torque: float


class SimulatedRig:
    """Steps one sample period at a time; the same seed gives the same readings."""

    def __init__(self, rig: Rig, plan: Plan, seed: int) -> None:
        self._rig = rig
        self._plan = plan
        self._random = np.random.default_rng(seed)
        self._period = 1 / rig.loop.rate
        coarse = steps_per_tick(rig.string, self._period)
        self._steps = max(coarse, math.ceil(self._period / FINE_STEP_S))
        step = self._period / self._steps
        line = cut(rig.string, step, SECTION_LENGTH, rig.survey, rig.wellbore)
        self._string = ForwardLine(line, rig.top_drive, rig.bit, step)
        self._gain = plan.damping * float(line.impedance[0])
        self._limit = TORQUE_RESERVE * float(rig.bit.static_torque + line.static.sum() + self._gain)
        self._fall = math.exp(-step / ROCK_MEMORY_S)
        self._rock = 0.0
        self._integral = 0.0
        self._speed = 0.0
        self._bit_speed = 0.0
        self._reported = 0.0
        self._done = 0

    def sample(self) -> Reading:
        """Run one sample period."""
        self._done += 1
        time_s = self._done * self._period
        bit = self._plan.bit_at(self._rig.bit, time_s)
        self._string.set_load(bit)
        torque = self._control(time_s)
        speeds, bit_speeds, bit_torques = self._string.run(
            np.full(self._steps, torque), self._rock_torque(bit.kinetic_torque if self._bit_speed else 0.0)
        )
        self._speed = float(speeds[-1])
        self._bit_speed = float(bit_speeds[-1])
        noise = self._rig.measurement
        return Reading(
            time_s,
            self._report(torque) + noise.torque_noise * self._random.standard_normal(),
            self._speed + noise.speed_noise * self._random.standard_normal(),
            time_s - self._string.bit_delay,
            self._bit_speed,
            float(bit_torques[-1]),
        )

    def _control(self, time_s: float) -> float:
        """Motor torque of the speed controller (PI, its integral held at the limit)."""
        drive = self._rig.top_drive
        miss = self._plan.speed_at(time_s) - self._speed / drive.gear_ratio
        wanted = self._gain * miss + self._integral
        given = max(-self._limit, min(self._limit, wanted))
        if given == wanted:
            self._integral += self._gain * miss * self._period / RESET_TIME_S
        return given / (drive.gear_ratio * drive.efficiency)

    def _report(self, torque: float) -> float:
        """The converter's own reading of torque, late by its lag."""
        lag = self._rig.top_drive.torque_lag
        self._reported += (torque - self._reported) * (-math.expm1(-self._period / lag) if lag else 1.0)
        return self._reported

    def _rock_torque(self, kinetic: float) -> Floats:
        """Torque of uneven rock over the coming steps: a first-order random process.

        In proportion to the kinetic torque (N·m) that the bit meets: none off bottom or at rest.
        """
        kick = math.sqrt(1 - self._fall**2)
        rocks = np.empty(self._steps)
        for k, random in enumerate(self._random.standard_normal(self._steps)):
            self._rock = self._fall * self._rock + kick * random
            rocks[k] = self._rock
        return self._plan.rock_noise * kinetic * rocks
