"""What looks odd in a configuration that is valid: likely slips, each as a sentence."""

import os
from collections.abc import Iterator
from ipaddress import ip_address
from itertools import pairwise

import numpy as np

from vsensor.config import Rig
from vsensor.estimator import component
from vsensor.estimator.sections import FINEST
from vsensor.estimator.tension import greatest_tension
from vsensor.estimator.wall import wall_friction

STEEL_WAVE_SPEEDS = (3000.0, 3300.0)
"""√(G/ρ) of drill-pipe and collar steels, m/s."""
LIKELY_LENGTHS = (10.0, 15_000.0)
"""From a test stand to the longest wells drilled, m."""
RUBBING_LENGTH = 1000.0
"""A string longer than this touches the wall somewhere, m."""
WIDEST = 1.0
"""No string is a metre wide: 127 was meant in mm, 5 in inches."""
IMPEDANCE_STEP = 10.0
UNSURVEYED = 100.0
"""The survey tool sits within some tens of metres of the bit, and each stand is surveyed, m."""
SLOW_LOOP = 20.0
"""Hz; below it much happens within a tick, and deviations come out too small, of short strings above all."""
LIKELY_MUDS = (800.0, 2500.0)
"""From oil to the heaviest brines and barite muds, kg/m³."""


def oddities(rig: Rig) -> list[str]:
    """Each likely slip in one sentence: where it is, what it says, what it means."""
    return [
        *_lengths(rig),
        *_sections(rig),
        *_strength(rig),
        *_friction(rig),
        *_well(rig),
        *_ends(rig),
        *_measurement(rig),
        *_loop(rig),
        *_network(rig),
    ]


def _lengths(rig: Rig) -> Iterator[str]:
    length = sum(part.length for part in rig.string)
    shortest, longest = LIKELY_LENGTHS
    if not shortest <= length <= longest:
        yield f"string: {length:g} m in all, where {shortest:g} to {longest:g} m is usual: is the unit right?"
    for number, part in enumerate(rig.string, 1):
        slots = component.delay(part) * rig.loop.rate
        if slots < 1 / FINEST:
            yield (
                f'string[{number}] "{part.name}": a wave runs {part.length:g} m in {slots:.2g} of a tick: '
                "it is lumped with its neighbour"
            )


def _sections(rig: Rig) -> Iterator[str]:
    slowest, fastest = STEEL_WAVE_SPEEDS
    for number, part in enumerate(rig.string, 1):
        if part.outer_diameter >= WIDEST:
            yield (
                f'string[{number}] "{part.name}": {part.outer_diameter:g} m across: '
                'is the unit right, as in "127 mm"?'
            )
        speed = component.wave_speed(part)
        if not slowest <= speed <= fastest:
            yield (
                f'string[{number}] "{part.name}": wave speed {speed:.0f} m/s: steel has {slowest:.0f} to '
                f"{fastest:.0f}; are shear_modulus and density right?"
            )
    for number, (above, below) in enumerate(pairwise(rig.string), 2):
        step = component.impedance(below) / component.impedance(above)
        if max(step, 1 / step) > IMPEDANCE_STEP:
            yield (
                f'string[{number}] "{below.name}": {step:.2g} times the impedance of "{above.name}" above: '
                "hardly a wave gets through; are the diameters right?"
            )


def _strength(rig: Rig) -> Iterator[str]:
    tops = np.cumsum([0.0, *(part.length for part in rig.string)])[:-1]
    hanging = "hang on it" if rig.wellbore else "hang on it in air"
    tensions = greatest_tension(rig.string, tops, rig.survey, rig.wellbore).tolist()
    for number, (part, tension) in enumerate(zip(rig.string, tensions, strict=True), 1):
        if part.tensile_strength is None:
            continue
        if part.torsional_strength is None:
            yield (
                f'string[{number}] "{part.name}": tensile_strength alone limits nothing: '
                "tension takes its share of torsional_strength, which is not given"
            )
        elif tension >= part.tensile_strength:
            yield (
                f'string[{number}] "{part.name}": {tension:.0f} N {hanging}, beyond its '
                f"tensile_strength of {part.tensile_strength:.0f} N"
            )


def _friction(rig: Rig) -> Iterator[str]:
    length = sum(part.length for part in rig.string)
    wall = wall_torque(rig)
    if length > RUBBING_LENGTH and not wall and not any(part.viscous_friction for part in rig.string):
        yield f"string: {length:.0f} m without any friction: what the wall takes is laid to the bit"
    if 0 < rig.bit.static_torque < wall:
        yield (
            f"bit.static_torque {rig.bit.static_torque:g} N·m is less than the wall's {wall:.0f} N·m: "
            "a small error in the friction hides the bit's torque"
        )


def wall_torque(rig: Rig) -> float:
    """Kinetic Coulomb friction of the whole string, N·m: what it takes to turn it slowly off bottom."""
    return float(wall_friction(rig.string, rig.survey, rig.wellbore).kinetic.sum())


def _well(rig: Rig) -> Iterator[str]:
    if not rig.wellbore:
        return
    beyond = sum(part.length for part in rig.string) - rig.survey[-1].measured_depth
    if beyond > UNSURVEYED:
        yield f"survey: ends {beyond:.0f} m above the bit: the well is taken to go straight on from there"
    lightest, heaviest = LIKELY_MUDS
    mud = rig.wellbore.mud_density
    if not lightest <= mud <= heaviest:
        yield (
            f"wellbore.mud_density {mud:g} kg/m³, where {lightest:g} to {heaviest:g} is usual: "
            "is the unit right?"
        )


def _ends(rig: Rig) -> Iterator[str]:
    if rig.top_drive.inertia == 0 and rig.top_drive.gear_ratio == 1:
        yield "top_drive: neither inertia nor gear: all of the motor's torque is taken to turn the string"
    if rig.bit.inertia == 0:
        yield "bit.inertia is 0: the bit stops and starts without delay"


def _measurement(rig: Rig) -> Iterator[str]:
    for name in ("torque_noise", "speed_noise"):
        if getattr(rig.measurement, name) == 0:
            yield f"measurement.{name} is 0: no sensor is without noise, and the stated deviations rest on it"
    wall = float(wall_friction(rig.string, rig.survey, rig.wellbore).static.sum())
    motor = (rig.bit.static_torque + wall) / (rig.top_drive.gear_ratio * rig.top_drive.efficiency)
    if rig.measurement.torque_limit < motor:
        yield (
            f"measurement.torque_limit {rig.measurement.torque_limit:g} N·m is below the {motor:.0f} N·m "
            "that break string and bit loose: such samples would be refused"
        )


def _loop(rig: Rig) -> Iterator[str]:
    if rig.loop.rate < SLOW_LOOP:
        yield (
            f"loop.rate is {rig.loop.rate:g} Hz: leave it at 100 Hz even where samples come no faster, "
            "for what lies between them is then doubted as it should be"
        )
    if missing := set(rig.loop.processors) - os.sched_getaffinity(0):
        yield (
            f"loop.processors: this machine has none of number {', '.join(map(str, sorted(missing)))}, "
            "or leaves it to others"
        )


def _network(rig: Rig) -> Iterator[str]:
    for number, endpoint in enumerate(rig.bus.listen, 1):
        if not _stays_here(endpoint):
            yield (
                f'bus.listen[{number}] "{endpoint}": open to other machines; '
                "without a zenoh_config that asks for it, nobody has to prove who they are"
            )
    if rig.bus.multicast_scouting:
        yield "bus.multicast_scouting is on: this machine makes itself known to the whole network segment"


def _stays_here(endpoint: str) -> bool:
    protocol, _, address = endpoint.partition("/")
    host = address.partition("?")[0].partition("#")[0].rpartition(":")[0].strip("[]")
    if protocol.startswith(("unix", "serial")) or host == "localhost":
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False
