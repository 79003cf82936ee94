"""Naive twin of the wall's friction: the soft string in plain Python, step by step from the bit up."""

import math
from collections.abc import Sequence
from itertools import pairwise

from vsensor.config import Component
from vsensor.config.well import Station, Wellbore

Vector = tuple[float, float, float]


def wall_torque(
    string: Sequence[Component], survey: Sequence[Station], wellbore: Wellbore, step: float
) -> list[float]:
    """Kinetic friction of each component, N·m."""
    torques = []
    bottom = sum(part.length for part in string)
    tension = -wellbore.weight_on_bit
    for part in reversed(string):
        area = math.pi * ((part.outer_diameter / 2) ** 2 - (part.inner_diameter / 2) ** 2)
        weight = 9.80665 * area * (part.density - wellbore.mud_density)
        start = max(0.0, bottom - part.length)
        side = 0.0
        while bottom > start:
            stations = [s.measured_depth for s in survey if s.measured_depth < bottom]
            top = max(start, bottom - step, *stations)
            ds = bottom - top
            fall = weight * tangent(survey, (top + bottom) / 2)[2] * ds
            side += side_force(survey, top, bottom, tension + fall / 2, weight) * ds
            tension += fall
            bottom = top
        torques.append(wellbore.friction_factor * side * part.tool_joint_diameter / 2)
    return torques[::-1]


def side_force(survey: Sequence[Station], top: float, bottom: float, tension: float, weight: float) -> float:
    """What the wall must bear of tension and weight, N/m: whatever of them does not act along the well."""
    before, after = tangent(survey, top), tangent(survey, bottom)
    along = tangent(survey, (top + bottom) / 2)
    pull = [tension * (b - a) / (bottom - top) for a, b in zip(before, after, strict=True)]
    load = [pull[0], pull[1], pull[2] + weight]
    share = sum(a * b for a, b in zip(load, along, strict=True))
    return math.hypot(*(a - share * b for a, b in zip(load, along, strict=True)))


def tangent(survey: Sequence[Station], depth: float) -> Vector:
    """North, east, down: between the directions of two stations by the angle's share."""
    above, below = survey[-1], survey[-1]
    for one, other in pairwise(survey):
        if one.measured_depth <= depth < other.measured_depth:
            above, below = one, other
    a, b = towards(above), towards(below)
    angle = math.acos(max(-1.0, min(1.0, sum(x * y for x, y in zip(a, b, strict=True)))))
    if angle < 1e-7:
        return a
    share = (depth - above.measured_depth) / (below.measured_depth - above.measured_depth)
    of_a = math.sin((1 - share) * angle) / math.sin(angle)
    of_b = math.sin(share * angle) / math.sin(angle)
    return (of_a * a[0] + of_b * b[0], of_a * a[1] + of_b * b[1], of_a * a[2] + of_b * b[2])


def towards(station: Station) -> Vector:
    aside = math.sin(station.inclination)
    return (
        aside * math.cos(station.azimuth),
        aside * math.sin(station.azimuth),
        math.cos(station.inclination),
    )
