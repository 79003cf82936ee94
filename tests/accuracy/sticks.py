"""Sticks foretold: how many, how long before, and how many in vain."""

from collections.abc import Iterator
from typing import NamedTuple

from tests.accuracy import words
from vsensor.config import Rig
from vsensor.estimator.model import with_length
from vsensor.grid import Grid
from vsensor.intake import Input
from vsensor.service.engine import Engine, tick_of
from vsensor.service.sticks import Sticks
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

FOR_S = 90.0
SEED = 7
DRILL_PIPE_M = (150.0, 400.0, 1000.0, 2500.0, 5000.0)
"""From a hole just begun to a deep one."""


class Foretold(NamedTuple):
    """What was foretold of sticks over a record."""

    sticks: Sticks
    ahead_s: float
    """How far ahead a forecast reaches, s."""


def foretold(rig: Rig, readings: Iterator[tuple[float, float]]) -> Foretold:
    """Run a sensor over pairs of motor torque and speed, one a tick, and count."""
    engine, sticks, grid = Engine(rig), Sticks(rig), Grid(rig.loop.rate)
    for number, (torque, speed) in enumerate(readings):
        sticks.see(engine.step(tick_of(Input(number, grid.after_ns(number), torque, speed, 0))))
    return Foretold(sticks, engine.estimator.forecast_horizon)


def simulated(rig: Rig) -> Foretold:
    """Of the simulated rig in stick-slip."""
    source = SimulatedRig(rig, PLANS[Scenario.STICK_SLIP], SEED)
    readings = (source.sample() for _ in range(round(FOR_S * rig.loop.rate)))
    return foretold(rig, ((reading.motor_torque, reading.motor_speed) for reading in readings))


def section(cases: Iterator[tuple[str, Foretold]], drilling: Rig) -> Iterator[str]:
    """What is said of them: of the reference cases, by name, and of strings of many lengths."""
    yield words.STICKS.format(seconds=FOR_S)
    for name, told in cases:
        yield _row(name, told)
    for length in DRILL_PIPE_M:
        yield _row(f"simulated, {length:g} m of drill pipe", simulated(with_length(drilling, length)))


def _row(name: str, told: Foretold) -> str:
    sticks, ahead_s = told
    counts = f"{sticks.foretold} | {sticks.missed} | {sticks.false}"
    warning = f"{sticks.lead_s:.2f} | {sticks.lead_s / ahead_s:.0%}" if sticks.foretold else "| "
    return f"| {name} | {ahead_s:.2f} | {counts} | {warning} |"
