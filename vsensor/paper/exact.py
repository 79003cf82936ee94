"""The shaft with its load under a step of torque, in closed form: the truth that all else is held against.

A torque at the top fixes there f + g = 2 T₀, and the load turns every wave f that arrives into
g = Γ f with Γ(s) = (J s + D − ζ)/(J s + D + ζ). So the wave that leaves the top is

    F(s) = (2 T₀/s) Σₙ (−Γ e^(−2θs))ⁿ

and each echo has a closed form: with p = (D + ζ)/J and a = 2ζ/J the inverse transform of
(s + p − a)ⁿ/(s + p)ⁿ⁺¹ is hₙ(t) = e^(−pt) Lₙ(a t), a Laguerre function. Γⁿ/s then follows by

    Sₙ₊₁ = (hₙ − hₙ₊₁ + q Sₙ)/p,     Rₙ = hₙ + p Sₙ,     S₀ = (1 − e^(−pt))/p,  q = (D − ζ)/J

which only adds numbers of like size. The rest of the shaft is d'Alembert's: with f known at the
top, and g = 2 T₀ − f there, both are known everywhere. No grid, and no error but rounding.
"""

import numpy as np
from numpy.typing import ArrayLike

from vsensor.config import Component
from vsensor.estimator import component
from vsensor.paper.shaft import Floats, Load

_AT_ONCE = 256
"""Times worked on together: what they need then stays in the processor's cache."""


class StepResponse:
    """The lossless shaft of (17) carrying the load of (19), a torque stepped on at time 0."""

    def __init__(self, shaft: Component, load: Load, torque: float) -> None:
        self.shaft = shaft
        self.torque = torque
        self._load = load
        self._zeta = component.impedance(shaft)
        self._theta = component.delay(shaft)

    def wave_down(self, time: ArrayLike) -> Floats:
        """The wave f = T₀ + ζω₀ that leaves the top, N·m, in the shape of `time` (n,)."""
        times = np.asarray(time, dtype=np.float64)
        pieces = np.array_split(times, 1 + len(times) // _AT_ONCE)
        return np.concatenate([self._wave_down(piece) for piece in pieces])

    def top_speed(self, time: ArrayLike) -> Floats:
        """ω₀ at each time, rad/s."""
        return np.asarray((self.wave_down(time) - self.torque * (np.asarray(time) >= 0)) / self._zeta)

    def end_speed(self, time: ArrayLike) -> Floats:
        """ω₁ at each time, rad/s."""
        return self.speed_at(self.shaft.length, time)

    def end_torque(self, time: ArrayLike) -> Floats:
        """T₁ at each time, N·m."""
        return self.torque_at(self.shaft.length, time)

    def speed_at(self, depth: float, time: ArrayLike) -> Floats:
        """Speed at a depth (m) from time 0 on, rad/s."""
        f, g = self._waves(depth, time)
        return (f - g) / (2 * self._zeta)

    def torque_at(self, depth: float, time: ArrayLike) -> Floats:
        """Torque at a depth (m) from time 0 on, N·m."""
        f, g = self._waves(depth, time)
        return (f + g) / 2

    def _waves(self, depth: float, time: ArrayLike) -> tuple[Floats, Floats]:
        times = np.asarray(time, dtype=np.float64)
        travel = depth / component.wave_speed(self.shaft)
        return self.wave_down(times - travel), 2 * self.torque - self.wave_down(times + travel)

    def _wave_down(self, time: Floats) -> Floats:
        trips = 1 + max(0, int(time.max(initial=0.0) / (2 * self._theta)))
        number = np.arange(trips)
        since = time - 2 * self._theta * number[:, None]
        echoes = np.where(since >= 0, self._echoes(np.maximum(since, 0.0)), 0.0)
        return np.asarray(2 * self.torque * ((-1.0) ** number @ echoes))

    def _echoes(self, since: Floats) -> Floats:
        """Rₙ, the step response of Γⁿ, in row n; `since` (trips, n) holds its time since it set out."""
        inertia, damping = self._load
        p, q = (damping + self._zeta) / inertia, (damping - self._zeta) / inertia
        a = 2 * self._zeta / inertia
        out = np.ones_like(since)
        laguerre, before = np.exp(-p * since), np.zeros_like(since)
        integral = -np.expm1(-p * since) / p
        for n in range(1, len(since)):
            # Row n − 1 is done with; Lₙ from the two before it: n Lₙ = (2n − 1 − x) Lₙ₋₁ − (n − 1) Lₙ₋₂.
            here, old, x = laguerre[1:], before[1:], a * since[n:]
            fresh = ((2 * n - 1 - x) * here - (n - 1) * old) / n
            integral = (here - fresh + q * integral[1:]) / p
            laguerre, before = fresh, here
            out[n] = fresh[0] + p * integral[0]
        return out
