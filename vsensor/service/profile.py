"""The string's profile as a message: what stands along it, how sure that is, and how near its limit."""

import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from vsensor.config import Component, Rig
from vsensor.estimator import component
from vsensor.estimator.along import SPEED, TORQUE, Stations
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.sections import Floats
from vsensor.estimator.strength import torsional_limit
from vsensor.estimator.tension import greatest_tension
from vsensor.messages import Estimate, Profile

RATE_HZ = 10.0
"""Profiles a second: three for each period of the fastest swing in the band of 3 Hz."""


class Layout(NamedTuple):
    """What does not change along a string: at n stations."""

    at: Stations
    names: list[str]
    """Of the components;"""
    limited_by: list[str]
    """what limits their torque,"""
    limit: Floats
    """and to what, N·m, shape (n,)."""
    stress: Floats
    """Shear stress of 1 N·m, Pa, shape (n,)."""


class Noted(NamedTuple):
    """What an estimator knew along the string once the tick of an estimate was run."""

    estimate: Estimate
    layout: Layout
    known: Floats
    """Speed, rad/s, and torque, N·m, at each station, shape (2, n)."""
    noise: Floats
    """What noise and rock leave of both as confirmed, one deviation, shape (2,),"""
    along: Floats
    """and at each station, shape (2, n)."""

    def deviation(self, quantity: int, told: float) -> Floats:
        """The deviation along the string: by noise, and downwards more of what the bit has besides.

        That is what uncertain parameters cost, which grows on the way, and a silent channel.
        """
        more = max(told**2 - self.noise[quantity] ** 2, 0.0)
        depth = self.layout.at.depth
        return np.asarray(np.sqrt(self.along[quantity] ** 2 + more * (depth / depth[-1]) ** 2))


class Reckoned(NamedTuple):
    """What was noted, and what follows of it: at each station, shape (n,)."""

    noted: Noted
    speed_std: Floats
    torque_std: Floats
    margin: Floats
    """Of the torque, until its limit; NaN where none is configured."""


class Profiler:
    """Notes what an estimator knows along its string; the message is made of it when there is time."""

    def __init__(self, rig: Rig, estimator: Estimator) -> None:
        self._tension = partial(greatest_tension, survey=rig.survey, wellbore=rig.wellbore)
        self._estimator = estimator
        self._every = max(1, round(rig.loop.rate / RATE_HZ))
        self._layout = lay_out(estimator.string, estimator.stations, self._tension)
        self.took_ns = 0
        """How long the last note took."""

    def due(self, number: int) -> bool:
        """Whether a profile is due with a tick."""
        return number % self._every == 0

    def note(self, estimate: Estimate) -> Noted | None:
        """What is known along the string where a profile is due; to be asked before another tick is run."""
        if not self.due(estimate.number) or not estimate.HasField("confirmed_bit_speed_std_rad_s"):
            return None
        begun = time.monotonic_ns()
        of = self._estimator
        if of.stations is not self._layout.at:  # the string was made longer
            self._layout = lay_out(of.string, of.stations, self._tension)
        noted = Noted(estimate, self._layout, of.profile().copy(), of.noise, of.profile_noise)
        self.took_ns = time.monotonic_ns() - begun
        return noted


def lay_out(
    string: tuple[Component, ...], at: Stations, tension: Callable[[Sequence[Component], Floats], Floats]
) -> Layout:
    """Lay out what does not change along a string, at its stations, under this tension."""
    parts = [string[number] for number in at.component]
    tensions = tension(string, at.depth).tolist()
    limits = [torsional_limit(part, bears) for part, bears in zip(parts, tensions, strict=True)]
    return Layout(
        at,
        names=[part.name for part in parts],
        limited_by=[limit.by if limit else "" for limit in limits],
        limit=np.array([limit.torque if limit else math.nan for limit in limits]),
        stress=np.array([component.stress_of_torque(part) for part in parts]),
    )


def reckon(noted: Noted) -> Reckoned:
    """The deviations and margins of what was noted."""
    with np.errstate(
        divide="ignore", invalid="ignore"
    ):  # nothing is left of a pipe that its own weight tears
        margin = 1 - np.abs(noted.known[TORQUE]) / noted.layout.limit
    return Reckoned(
        noted,
        noted.deviation(SPEED, noted.estimate.confirmed_bit_speed_std_rad_s),
        noted.deviation(TORQUE, noted.estimate.confirmed_bit_torque_std_nm),
        margin,
    )


def profile_of(reckoned: Reckoned) -> Profile:
    """The profile of a tick that was noted, at the confirmed time of its estimate."""
    (estimate, layout, (speed, torque), *_), speed_std, torque_std, margin = reckoned
    profile = Profile(
        number=estimate.number,
        time_ns=estimate.confirmed_time_ns,
        quality=estimate.quality,
        reasons=estimate.reasons,
        depth_m=layout.at.depth.tolist(),
        speed_rad_s=speed.tolist(),
        speed_std_rad_s=speed_std.tolist(),
        torque_nm=torque.tolist(),
        torque_std_nm=torque_std.tolist(),
        shear_stress_pa=(torque * layout.stress).tolist(),
        shear_stress_std_pa=(torque_std * layout.stress).tolist(),
        torque_limit_nm=layout.limit.tolist(),
        margin=margin.tolist(),
    )
    if not np.isnan(margin).all():
        _name_weakest(profile, layout, int(np.nanargmin(margin)))
    return profile


def _name_weakest(profile: Profile, layout: Layout, at: int) -> None:
    profile.weakest_component = layout.names[at]
    profile.weakest_depth_m = profile.depth_m[at]
    profile.weakest_torque_nm = profile.torque_nm[at]
    profile.weakest_torque_std_nm = profile.torque_std_nm[at]
    profile.weakest_limit_nm = profile.torque_limit_nm[at]
    profile.weakest_limited_by = layout.limited_by[at]
    profile.weakest_margin = profile.margin[at]
