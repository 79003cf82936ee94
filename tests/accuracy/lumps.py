"""A yardstick: the string as two lumps and a spring, watched by a Kalman filter.

This is what a virtual sensor without waves is (the paper's eq. 1 to 3, turned round). The top lump is the
top drive and half of the string, the lower one the bit and the other half; the spring is the string's
components in series; half of the wall's friction rubs on either lump. Motor torque is a known input, motor
speed is measured, the bit's torque is a random walk:

    J_t dω_t/dt = T_motor − kφ − c ω_t − F(ω_t)        dφ/dt = ω_t − ω_b
    J_b dω_b/dt = kφ − c ω_b − F(ω_b) − T_bit          T_bit walks

The converter's lag is left out: 5 ms matter little to a pendulum of several seconds. Coulomb friction F
enters as a known torque by the sign of the estimated speed; without it the bit's torque would be wrong by
its sum.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from tests.accuracy.score import Answer, Floats
from tests.cases import Columns
from vsensor.config import Rig
from vsensor.estimator import component

FADE_SPEED = 1.0
"""Coulomb friction fades to zero below this speed, rad/s, so that it does not chatter."""


class Tuning(NamedTuple):
    """What the filter has to be told beside the rig."""

    walk: float
    """Variance that the bit's torque gains in a second, N²·m²/s."""
    excess: float
    """Noise of the known torque in multiples of the channel's: it stands for what lumps cannot do."""


TUNINGS = tuple(
    Tuning(10.0**power, excess) for power in range(10) for excess in (1.0, 10.0, 30.0, 100.0, 300.0)
)
"""What to try: walks from 1 N·m to 32 kN·m in a second."""

SPEED, BIT_SPEED, TWIST, BIT_TORQUE = range(4)


class Lumps(NamedTuple):
    """Two lumps, SI."""

    top_inertia: float
    bit_inertia: float
    stiffness: float
    viscous: float
    """Friction on either lump, N·m·s/rad."""
    coulomb: float
    """The same that does not grow with speed, N·m."""

    @classmethod
    def of(cls, rig: Rig) -> Self:
        """A rig as two lumps."""
        half = sum(component.inertia(part) for part in rig.string) / 2
        return cls(
            top_inertia=rig.top_drive.inertia + half,
            bit_inertia=rig.bit.inertia + half,
            stiffness=1 / sum(1 / component.stiffness(part) for part in rig.string),
            viscous=sum(part.viscous_friction * part.length for part in rig.string) / 2,
            coulomb=sum(part.coulomb_friction * part.length for part in rig.string) / 2,
        )

    def stepped(self, step_s: float) -> tuple[Floats, Floats]:
        """State (4, 4) and input (4, 2: torque on either lump) over a step in which the inputs hold."""
        top, bit, k, c = self.top_inertia, self.bit_inertia, self.stiffness, self.viscous
        rates = np.zeros((6, 6))
        rates[SPEED] = -c / top, 0, -k / top, 0, 1 / top, 0
        rates[BIT_SPEED] = 0, -c / bit, k / bit, -1 / bit, 0, 1 / bit
        rates[TWIST, :2] = 1, -1
        both = expm(rates * step_s)
        return both[:4, :4], both[:4, 4:]


@dataclass(frozen=True)
class Filter:
    """The Kalman filter in its steady state."""

    lumps: Lumps
    step_s: float
    torque_noise: float
    """Standard deviation of the known torque, N·m."""
    speed_noise: float
    walk: float
    """Variance that the bit's torque gains in a second, N²·m²/s."""

    def run(self, motor_torque: Floats, motor_speed: Floats) -> "Filtered":
        """Predict and correct through n samples of motor torque and speed."""
        a, b = self.lumps.stepped(self.step_s)
        gained = np.outer(b[:, 0], b[:, 0]) * self.torque_noise**2
        gained[BIT_TORQUE, BIT_TORQUE] += self.walk * self.step_s
        measured = np.eye(4)[:, :1]
        covariance = solve_discrete_are(a.T, measured, gained, np.array([[self.speed_noise**2]]))
        variance = float(covariance[SPEED, SPEED]) + self.speed_noise**2
        gain = covariance[:, SPEED] / variance
        states, innovations = np.empty((len(motor_speed), 4)), np.empty(len(motor_speed))
        state = np.zeros(4)
        for n, (torque, speed) in enumerate(zip(motor_torque, motor_speed, strict=True)):
            states[n], innovations[n] = state, speed - state[SPEED]
            state = state + gain * innovations[n]
            rubbing = np.clip(state[:2] / FADE_SPEED, -1, 1) * self.lumps.coulomb
            state = a @ state + b @ (np.array([torque, 0.0]) - rubbing)
        closed = a - np.outer(a @ gain, measured)
        return Filtered(states, innovations, covariance, variance, closed)


class Filtered(NamedTuple):
    """Predictions of each sample (n, 4) from those before, and what its speed said against them (n,)."""

    states: Floats
    innovations: Floats
    covariance: Floats
    variance: float
    closed: Floats
    """From one prediction's error to the next one's, A (I − K C)."""

    def smoothed(self, lag: int) -> tuple[Floats, Floats]:
        """States (n, 4) heard `lag` samples on, NaN at the end, and their standard deviations (4,).

        Anderson and Moore (1979), section 7.3: each later innovation adds P (closedᵀ)ⁱ Cᵀ/S of itself.
        """
        n = len(self.innovations) - lag
        states, covariance = np.full_like(self.states, np.nan), self.covariance.copy()
        states[:n] = self.states[:n]
        carried = np.eye(4)[:, SPEED]
        for i in range(lag + 1):
            gain = self.covariance @ carried / self.variance
            states[:n] += np.outer(self.innovations[i : n + i], gain)
            covariance -= np.outer(gain, gain) * self.variance
            carried = self.closed.T @ carried
        return states, np.sqrt(np.diag(covariance))

    def likelihood(self, start: int) -> float:
        """Logarithm of how likely the innovations from sample `start` on are, but for a constant."""
        heard = self.innovations[start:]
        return -float(np.sum(heard**2) / self.variance + len(heard) * math.log(self.variance)) / 2


def watched(rig: Rig, surface: Columns, tuning: Tuning) -> Filtered:
    """What the filter makes of a surface table."""
    drive, noise = rig.top_drive, rig.measurement
    passed = drive.gear_ratio * drive.efficiency
    watching = Filter(
        lumps=Lumps.of(rig),
        step_s=1 / rig.loop.rate,
        torque_noise=noise.torque_noise * passed * tuning.excess,
        speed_noise=noise.speed_noise / drive.gear_ratio,
        walk=tuning.walk,
    )
    return watching.run(surface["motor_torque_nm"] * passed, surface["motor_speed_rad_s"] / drive.gear_ratio)


def told(filtered: Filtered, time_s: Floats, lag: int) -> Answer:
    """What the filter says of the bit, `lag` samples late; 0 is now."""
    states, std = filtered.smoothed(lag)
    spread = np.broadcast_to(std, states.shape)
    return Answer(
        time_s, states[:, BIT_SPEED], spread[:, BIT_SPEED], states[:, BIT_TORQUE], spread[:, BIT_TORQUE]
    )
