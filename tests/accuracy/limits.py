"""What nobody can know better: limits that noise and rock set to any sensor, worked out by frequency.

The string is exact here, without sections or steps: each component is the matrix of the paper's eq. (12),
with the wall's viscous friction in it. The load law is its slope at the speed at hand, so these limits are
for a bit that turns on without sticking. Coulomb friction is constant then, and tells nothing. The rock's
own torque is an Ornstein-Uhlenbeck process with the covariance σ² e^(−|t|/τ).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Bit, Component, Rig
from vsensor.estimator.component import polar_moment

Complexes = NDArray[np.complex128]

STEP_S, STEPS = 1e-3, 1 << 15
"""Grid of the response in time: 33 s, ten times what is asked of it."""
SHIFT = 0.5
"""Real part of s on which responses are sampled, 1/s: it keeps clear of what never dies away at s = 0."""
SPACING_HZ = 0.005
"""Spacing of frequencies in the smoother's limit, far below the string's first mode."""
BROAD = 1e3
"""Spectrum of a bit speed of which nothing is known beforehand, (rad/s)²/Hz."""


class Rock(NamedTuple):
    """The rock's own torque."""

    std: float
    """Standard deviation, N·m."""
    time: float
    """Correlation time, s."""

    def spectrum(self, hertz: NDArray[np.floating]) -> NDArray[np.floating]:
        """One-sided spectrum, N²·m²/Hz."""
        return 4 * self.std**2 * self.time / (1 + (2 * np.pi * hertz * self.time) ** 2)


class Limit(NamedTuple):
    """Standard deviations that no estimate of the bit can be below."""

    speed: float
    torque: float


def slope(bit: Bit, speed: float) -> float:
    """How the load law rises with speed, N·m·s/rad."""
    fall = (bit.static_torque - bit.kinetic_torque) / bit.stribeck_speed
    return bit.viscous_friction - fall * float(np.exp(-speed / bit.stribeck_speed))


def foretold(rig: Rig, rock: Rock, speed: float, horizon_s: float) -> Limit:
    """Least error of a prediction that knows everything but what the rock does within the horizon.

    The rock's innovations since then come out through the bit's response g to e^(−t/τ):
    variance = 2σ²/τ ∫ g² dt, from 0 to the horizon. Nothing comes back from the top: what does has been
    measured there. So the first component is endless, and its impedance all that is seen of it.
    """
    s = _on_line(SHIFT, np.fft.rfftfreq(STEPS, STEP_S))
    seen = _seen_from_below(rig.string, s)
    law = slope(rig.bit, speed)
    response = -1 / ((s + 1 / rock.time) * (s * rig.bit.inertia + law + seen))
    count = round(horizon_s / STEP_S)
    time = STEP_S * np.arange(count)
    of_speed = np.fft.irfft(response)[:count] / STEP_S * np.exp(SHIFT * time)
    of_torque = law * of_speed + np.exp(-time / rock.time)
    gained = 2 * rock.std**2 / rock.time * STEP_S
    return Limit(*(float(np.sqrt(gained * np.sum(of**2))) for of in (of_speed, of_torque)))


def confirmed(rig: Rig, rock: Rock, speed: float) -> Limit:
    """Least error of a bit heard through noisy channels, before and after, by one who knows law and rock.

    A Wiener smoother without end: at each frequency the bit's speed, of which nothing is known, and
    the rock's torque, of which the spectrum is, are told by the two channels of motor torque and speed.
    The variances that remain are summed over all frequencies.
    """
    hertz = np.arange(SPACING_HZ / 2, rig.loop.rate / 2, SPACING_HZ)
    s = _on_line(0.0, hertz)
    law = slope(rig.bit, speed)
    nothing, one = np.zeros_like(s), np.ones_like(s)
    # Torque and speed at the string's end, of a unit of bit speed and of a unit of the rock's torque.
    end = _matrix(s * rig.bit.inertia + law, one, one, nothing)
    top = _through(rig.string, s) @ end
    heard = _matrix(one, s * rig.top_drive.inertia, nothing, one) @ top
    noise = np.array([rig.measurement.torque_noise, rig.measurement.speed_noise]) ** 2 * 2 / rig.loop.rate
    known = heard.conj().swapaxes(1, 2) @ (heard / noise[:, None])
    known[:, 0, 0] += 1 / BROAD
    known[:, 1, 1] += 1 / rock.spectrum(hertz)
    left = np.linalg.inv(known)
    of_torque = np.array([law, 1.0])
    torque = np.einsum("i,fij,j->f", of_torque, left, of_torque)
    return Limit(*(float(np.sqrt(of.real.sum() * SPACING_HZ)) for of in (left[:, 0, 0], torque)))


def _on_line(real: float, hertz: NDArray[np.floating]) -> Complexes:
    """Values of s with one real part, at each frequency."""
    return np.asarray(real + 2j * np.pi * hertz, dtype=np.complex128)


def _through(string: Sequence[Component], s: Complexes) -> Complexes:
    """From torque and speed at the bottom to those at the top, shape (n, 2, 2)."""
    whole: Complexes = np.broadcast_to(np.eye(2, dtype=np.complex128), (len(s), 2, 2))
    for part in string:
        angle, impedance = _constants(part, s)
        cosh, sinh = np.cosh(angle), np.sinh(angle)
        whole = whole @ _matrix(cosh, impedance * sinh, sinh / impedance, cosh)
    return whole


def _seen_from_below(string: Sequence[Component], s: Complexes) -> Complexes:
    """Torque over speed that the string's end shows to a bit that turns it, the first component endless."""
    _, above = _constants(string[0], s)
    through = _through(string[1:], s)
    shown: Complexes = (through[:, 0, 1] + above * through[:, 1, 1]) / (
        through[:, 0, 0] + above * through[:, 1, 0]
    )
    return shown


def _constants(part: Component, s: Complexes) -> tuple[Complexes, Complexes]:
    """Γl and ξ of eq. (8) to (12): L = ρJ, C = 1/(GJ), R the wall's viscous friction, G = 0."""
    moment = polar_moment(part)
    series, shunt = s * part.density * moment + part.viscous_friction, s / (part.shear_modulus * moment)
    per_metre: Complexes = np.sqrt(series * shunt)
    impedance: Complexes = np.sqrt(series / shunt)
    return part.length * per_metre, impedance


def _matrix(a: Complexes, b: Complexes, c: Complexes, d: Complexes) -> Complexes:
    """Matrices (n, 2, 2) of their elements, row by row."""
    return np.stack([a, b, c, d], axis=-1).reshape(-1, 2, 2)
