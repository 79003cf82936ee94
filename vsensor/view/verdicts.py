"""What a number means, in a word and a grade: the same words in large figures, bars and pages."""

import math
from enum import IntEnum
from typing import Literal, NamedTuple

from vsensor.messages import Estimate, Profile, Status
from vsensor.quality import Quality, Reason

STANDS = 0.5
"""Bit speed below which it stands, rad/s: as the sensor counts it (Status.stuck_share)."""
UNEVEN, STICK_SLIP = 0.5, 1.0
"""Severity: from 1 on the bit comes to a stand; half of that is our own bound."""
NEAR = 0.1
"""Margin to a limit below which it is near: our own bound."""


class Grade(IntEnum):
    """How a driller should take it."""

    UNKNOWN = 0
    WELL = 1
    CARE = 2
    ALARM = 3


class Verdict(NamedTuple):
    """A word, how to take it, and why, if there is more to say."""

    word: str
    grade: Grade
    why: str = ""


UNKNOWN = Verdict("", Grade.UNKNOWN)


def bit_state(estimate: Estimate, kind: Literal["confirmed", "now"]) -> Verdict:
    """Does the bit turn? At rest with the whole string it rests, which is nothing to be alarmed at."""
    if not estimate.HasField(f"{kind}_bit_speed_rad_s"):  # type: ignore[arg-type]
        return UNKNOWN
    speed = getattr(estimate, f"{kind}_bit_speed_rad_s")
    top = estimate.top_speed_rad_s
    if abs(speed) < STANDS:
        return Verdict("stands", Grade.ALARM) if abs(top) >= 2 * STANDS else Verdict("rests", Grade.UNKNOWN)
    if abs(top) >= 2 * STANDS and speed * top < 0:
        return Verdict("turns back", Grade.ALARM)
    return Verdict("turns", Grade.WELL)


def roughness(status: Status) -> Verdict:
    """How the bit swings about its mean speed."""
    if not status.HasField("severity"):
        return UNKNOWN
    if status.severity >= STICK_SLIP:
        return Verdict("stick-slip", Grade.ALARM)
    return Verdict("uneven", Grade.CARE) if status.severity >= UNEVEN else Verdict("smooth", Grade.WELL)


def strength(profile: Profile) -> Verdict:
    """How near the string is to the torque that it bears, where it is nearest."""
    if not profile.HasField("weakest_margin") or math.isnan(profile.weakest_margin):
        return UNKNOWN
    why = f"{profile.weakest_component}, {profile.weakest_limited_by}"
    if profile.weakest_margin < 0:
        return Verdict("over a limit", Grade.ALARM, why)
    if profile.weakest_margin < NEAR:
        return Verdict("near a limit", Grade.CARE, why)
    return Verdict("within limits", Grade.WELL, why)


def trust(estimate: Estimate) -> Verdict:
    """How far the estimate can be trusted; unknown before the first, and for a verdict not known here."""
    quality = next((grade for grade in Quality if int(grade) == int(estimate.quality)), None)
    if quality is None:
        return UNKNOWN
    grade = {Quality.GOOD: Grade.WELL, Quality.UNCERTAIN: Grade.CARE, Quality.BAD: Grade.ALARM}[quality]
    return Verdict(quality.name.lower(), grade, Reason(estimate.reasons).words())
