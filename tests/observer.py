"""Rigs and records for tests of the observer: a string with exactly the noise assumed, and its truth."""

import math
from typing import NamedTuple

import numpy as np

from tests.strings import COLLAR, PIPE, rig
from vsensor.config import Rig
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.forward import ForwardLine
from vsensor.estimator.gains import Gains
from vsensor.estimator.responses import rock_fade
from vsensor.estimator.sections import Floats

ALONE = {"enabled": False, "delay": 1e-6, "impedance": 1e-6, "inertia": 1e-6, "friction": 1e-6}
"""The configuration is the truth, and known to be."""
LOSSY = PIPE.model_copy(update={"length": 600.0, "viscous_friction": 0.1})
LINEAR = rig(
    LOSSY,
    COLLAR,
    rate=20.0,
    bit={"inertia": 50.0, "viscous_friction": 60.0},
    top_drive={"inertia": 800.0, "torque_lag": 0.0},
    estimator={"learn": False},
    tuning=ALONE,
)
"""A string without Coulomb friction under a load law that is known."""


class Record(NamedTuple):
    """What the motor said each tick, and the bit's truth at the string's last step, a travel time earlier."""

    torque: Floats
    speed: Floats
    bit_speed: Floats
    bit_torque: Floats


def drilled(of: Rig, torque: Floats, rock: float, seed: int, *, noisy: bool = True) -> Record:
    """The rig's own string under these motor torques, its rock's deviation `rock` (N·m)."""
    random = np.random.default_rng(seed)
    estimator, n = Estimator(of), len(torque)
    steps = estimator.steps_per_tick
    string = ForwardLine(estimator.line, of.top_drive, of.bit, 1 / of.loop.rate / steps)
    fade, level = rock_fade(of.loop.rate * steps), 0.0
    kick = rock * math.sqrt(1 - rock_fade(of.loop.rate) ** 2)
    external = np.empty(n * steps)
    for step in range(n * steps):
        level = fade * level + (kick * random.standard_normal() if step % steps == 0 else 0.0)
        external[step] = level
    motor = np.interp(np.arange(1, n * steps + 1) / steps, np.arange(n + 1), np.append(torque[0], torque))
    top, bit_speed, bit_torque = (of_step[steps - 1 :: steps] for of_step in string.run(motor, external))
    noise = of.measurement
    return Record(
        torque + noisy * noise.torque_noise * random.standard_normal(n),
        top + noisy * noise.speed_noise * random.standard_normal(n),
        bit_speed,
        bit_torque,
    )


def pinned(of: Rig, level: int) -> Estimator:
    """An estimator that has but one level of gains."""
    estimator = Estimator(of)
    one = Gains(*(column[level : level + 1] for column in estimator._configured.gains))
    estimator._configured = estimator._configured._replace(gains=one)
    estimator.reset()
    return estimator


def innovations(estimator: Estimator, record: Record) -> Floats:
    """What each tick's measured speed said beyond the model's."""
    told = np.empty(len(record.torque))
    for k, (torque, speed) in enumerate(zip(record.torque, record.speed, strict=True)):
        estimator.step(float(torque), float(speed))
        told[k] = estimator._state.innovation[0]
    return told
