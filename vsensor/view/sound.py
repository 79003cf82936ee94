"""Messages that make sense: what else comes over a bus that others write to as well is not drawn."""

import math
from collections.abc import Sequence
from itertools import pairwise

from google.protobuf.message import Message as Protobuf

from vsensor.messages import Description, Estimate, Message, Profile, Status, Tick

BELIEVABLE = 1e12
"""No SI value of a drill string is as large, a modulus or a stress included."""


def sound(message: Message) -> bool:
    """Whether a message can be drawn: its numbers are finite, its arrays fit together."""
    match message:
        case Tick():
            return _are(message.motor_torque_nm, message.motor_speed_rad_s)
        case Profile():
            values = message.speed_rad_s, message.torque_nm, message.shear_stress_pa
            limits = len(message.torque_limit_nm) in (0, len(message.depth_m))
            return limits and _is_down(message.depth_m, *values)
        case Description():
            of = message
            places = of.north_m, of.east_m, of.vertical_depth_m, of.impedance_nm_s_rad, of.compliance_rad_nm_m
            drive = of.gear_ratio > 0 and of.efficiency > 0 and _are(of.gear_ratio, of.efficiency)
            return drive and _are(*of.mode_hz) and _is_down(of.depth_m, *places)
        case Estimate() | Status():
            return _is_finite(message)
    return True


def _is_down(depths: Sequence[float], *columns: Sequence[float]) -> bool:
    """Whether depths go down from the top, with a value of each column for each."""
    if len(depths) < 2 or any(len(column) != len(depths) for column in columns):
        return False
    descends = all(above <= below for above, below in pairwise(depths))
    return descends and depths[-1] > depths[0] >= 0 and _are(*depths) and all(_are(*c) for c in columns)


def _is_finite(message: Protobuf) -> bool:
    """Whether all numbers that are set are; of messages within, too."""
    for field, value in message.ListFields():
        if field.type == field.TYPE_DOUBLE:
            if not (_are(*value) if field.is_repeated else _are(value)):
                return False
        elif field.type == field.TYPE_MESSAGE and not all(
            map(_is_finite, value if field.is_repeated else [value])
        ):
            return False
    return True


def _are(*numbers: float) -> bool:
    """Whether numbers are finite, and not beyond belief."""
    return all(math.isfinite(number) and abs(number) < BELIEVABLE for number in numbers)
