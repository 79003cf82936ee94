"""A rig in software: speed controller, motor, string and rock, sampled with the noise of real sensors."""

import math
from typing import NamedTuple

import numpy as np

from vsensor.config import Rig
from vsensor.estimator.forward import Controller, ForwardLine
from vsensor.estimator.sections import Floats, cut, steps_per_tick
from vsensor.simulate.scenario import Plan

FINE_STEP_S = 1e-3
"""The simulation steps at least so finely, finer than the estimator, so as to be a test of it; the speed
controller with it, as a converter's does: what a motor holds for a whole sample is half a sample late."""
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
        self._ago = step * np.arange(self._steps, dtype=np.float64)[::-1]
        line = cut(rig.string, step, SECTION_LENGTH, rig.survey, rig.wellbore)
        self._string = ForwardLine(line, rig.top_drive, rig.bit, step)
        gain = plan.damping * float(line.impedance[0])
        limit = TORQUE_RESERVE * float(rig.bit.static_torque + line.static.sum() + gain)
        self._controller = Controller(gain, gain * step / RESET_TIME_S, limit)
        lag = rig.top_drive.torque_lag
        self._kept = math.exp(-step / lag) if lag else 0.0
        self._fall = math.exp(-step / ROCK_MEMORY_S)
        self._rock = 0.0
        self._bit_speed = 0.0
        self._reported = 0.0
        self._done = 0

    def sample(self) -> Reading:
        """Run one sample period."""
        self._done += 1
        time_s = self._done * self._period
        bit = self._plan.bit_at(self._rig.bit, time_s)
        self._string.set_load(bit)
        torques, speeds, bit_speeds, bit_torques = self._string.control(
            self._controller,
            self._plan.speed_at(time_s - self._ago),
            self._rock_torque(bit.kinetic_torque if self._bit_speed else 0.0),
        )
        self._bit_speed = float(bit_speeds[-1])
        noise = self._rig.measurement
        return Reading(
            time_s,
            self._report(torques) + noise.torque_noise * self._random.standard_normal(),
            float(speeds[-1]) + noise.speed_noise * self._random.standard_normal(),
            time_s - self._string.bit_delay,
            self._bit_speed,
            float(bit_torques[-1]),
        )

    def _report(self, torques: Floats) -> float:
        """The converter's own reading of torque, late by its lag."""
        for torque in torques.tolist():
            self._reported = torque + (self._reported - torque) * self._kept
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
