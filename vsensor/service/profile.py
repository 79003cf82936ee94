"""The string's profile as a message: what stands along it, how sure that is, and how near its limit."""

import math

import numpy as np

from vsensor.config import Rig
from vsensor.estimator import component
from vsensor.estimator.along import SPEED, TORQUE
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.sections import Floats
from vsensor.estimator.strength import hanging_weight, torsional_limit
from vsensor.messages import Estimate, Profile

RATE_HZ = 10.0
"""Profiles a second: three for each period of the fastest swing in the band of 3 Hz."""


class Profiler:
    """Makes profiles of one rig's string from what its estimator knows."""

    def __init__(self, rig: Rig, estimator: Estimator) -> None:
        self._rig = rig
        self._estimator = estimator
        self._every = max(1, round(rig.loop.rate / RATE_HZ))
        self._lay_out()

    def _lay_out(self) -> None:
        at, string = self._estimator.stations, self._estimator.string
        self._laid_out = at
        self._share = at.depth / at.depth[-1]
        parts = [string[number] for number in at.component]
        # Off bottom and straight down tension is greatest: on the safe side in any well.
        mud = self._rig.wellbore.mud_density if self._rig.wellbore else 0.0
        tensions = hanging_weight(string, at.depth, mud).tolist()
        limits = [torsional_limit(part, tension) for part, tension in zip(parts, tensions, strict=True)]
        self._names = [part.name for part in parts]
        self._limited_by = [limit.by if limit else "" for limit in limits]
        self._limit = np.array([limit.torque if limit else math.nan for limit in limits])
        self._stress = np.array([component.stress_of_torque(part) for part in parts])

    def is_due(self, estimate: Estimate) -> bool:
        """Whether there is a profile to this estimate."""
        return not estimate.number % self._every and estimate.HasField("confirmed_bit_speed_std_rad_s")

    def look(self, estimate: Estimate) -> Profile | None:
        """The profile at the confirmed time of the newest estimate; None where there is none."""
        if not self.is_due(estimate):
            return None
        if self._estimator.stations is not self._laid_out:  # the string was made longer
            self._lay_out()
        speed, torque = self._estimator.profile()
        speed_noise, torque_noise = self._estimator.noise
        speed_std = self._widened(SPEED, estimate.confirmed_bit_speed_std_rad_s, float(speed_noise))
        torque_std = self._widened(TORQUE, estimate.confirmed_bit_torque_std_nm, float(torque_noise))
        with np.errstate(
            divide="ignore", invalid="ignore"
        ):  # nothing is left of a pipe that its own weight tears
            margin = 1 - np.abs(torque) / self._limit
        profile = Profile(
            number=estimate.number,
            time_ns=estimate.confirmed_time_ns,
            quality=estimate.quality,
            reasons=estimate.reasons,
            depth_m=self._estimator.stations.depth.tolist(),
            speed_rad_s=speed.tolist(),
            speed_std_rad_s=speed_std.tolist(),
            torque_nm=torque.tolist(),
            torque_std_nm=torque_std.tolist(),
            shear_stress_pa=(torque * self._stress).tolist(),
            shear_stress_std_pa=(torque_std * self._stress).tolist(),
            torque_limit_nm=self._limit.tolist(),
            margin=margin.tolist(),
        )
        if not np.isnan(margin).all():
            self._name_weakest(profile, int(np.nanargmin(margin)))
        return profile

    def _name_weakest(self, profile: Profile, at: int) -> None:
        profile.weakest_component = self._names[at]
        profile.weakest_depth_m = profile.depth_m[at]
        profile.weakest_torque_nm = profile.torque_nm[at]
        profile.weakest_torque_std_nm = profile.torque_std_nm[at]
        profile.weakest_limit_nm = profile.torque_limit_nm[at]
        profile.weakest_limited_by = self._limited_by[at]
        profile.weakest_margin = profile.margin[at]

    def _widened(self, quantity: int, told: float, noise: float) -> Floats:
        """The deviation along the string: by noise, and downwards more of what the bit has besides.

        That is what uncertain parameters cost, which grows on the way, and a silent channel.
        """
        more = max(told**2 - noise**2, 0.0)
        return np.asarray(np.sqrt(self._estimator.profile_noise[quantity] ** 2 + more * self._share**2))
