"""Sessions for the benchmarks: what a daemon records of a simulated rig, over and over."""

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Rig, effective_toml
from vsensor.grid import NS
from vsensor.messages import (
    BIT_ESTIMATE,
    BIT_SPEED,
    BIT_TORQUE,
    SENSOR_TICK,
    STRING_PROFILE,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Sample,
)
from vsensor.recording.writer import Compression, SessionWriter
from vsensor.service.engine import Engine
from vsensor.service.profile import Profiler, profile_of, reckon
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

PASSED_S = 10.0
"""The first seconds, in which the estimator warms up, are left out."""


class Told(NamedTuple):
    """One message as it goes to the recorder."""

    topic: str
    data: bytes
    time_ns: int


def recorded(rig: Rig, seconds: float) -> list[Told]:
    """What a daemon records of so many seconds in stick-slip, from the time on that it is warm."""
    source, engine = SimulatedRig(rig, PLANS[Scenario.STICK_SLIP], seed=1), Engine(rig)
    profiler = Profiler(rig, engine.estimator)
    told: list[Told] = []
    for number in range(round((PASSED_S + seconds) * rig.loop.rate)):
        reading = source.sample()
        time_ns = round(reading.time_s * 1e9)
        for topic, value in ((SURFACE_TORQUE, reading.motor_torque), (SURFACE_SPEED, reading.motor_speed)):
            sample = Sample(time_ns=time_ns, value=value, sequence=number)
            told.append(Told(topic, sample.SerializeToString(), time_ns))
            for tick, estimate in engine.take(topic, sample):
                speed = Sample(time_ns=time_ns, value=estimate.now_bit_speed_rad_s, sequence=number)
                torque = Sample(time_ns=time_ns, value=estimate.now_bit_torque_nm, sequence=number)
                noted = profiler.note(estimate)
                of_tick = (
                    (SENSOR_TICK, tick),
                    (BIT_ESTIMATE, estimate),
                    (BIT_SPEED, speed),
                    (BIT_TORQUE, torque),
                    *(((STRING_PROFILE, profile_of(reckon(noted))),) if noted else ()),
                )
                told += (Told(to, message.SerializeToString(), time_ns) for to, message in of_tick)
    return [each for each in told if each.time_ns >= PASSED_S * 1e9]


def write(
    path: Path, rig: Rig, told: list[Told], times: int, compression: Compression
) -> NDArray[np.float64]:
    """Write messages so many times over, put on the disk each second; how long each took, s; shape (n,)."""
    span_ns = told[-1].time_ns - told[0].time_ns
    taken = np.empty(len(told) * times)
    with SessionWriter(
        path, configuration=effective_toml(rig), metadata={"rig": rig.rig.name}, compression=compression
    ) as writer:
        synced_ns = told[0].time_ns
        for lap in range(times):
            for k, (topic, data, told_ns) in enumerate(told, lap * len(told)):
                time_ns = told_ns + lap * span_ns
                begun = time.perf_counter()
                writer.write(topic, data, time_ns, time_ns)
                if time_ns - synced_ns >= NS:
                    writer.sync()
                    synced_ns = time_ns
                taken[k] = time.perf_counter() - begun
    return taken
