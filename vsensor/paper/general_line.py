"""The general line with losses, eq. (4) to (17): any medium in which waves run, as a two-port.

Something that is across (voltage, pressure, torque) and something that goes through (current, flow,
speed) change along any uniform line by

    du/dx = −(L s + R) y        dy/dx = −(C s + G) u                                    (4) to (11)

R and G are what is lost: in series (a wire's resistance, a fluid's friction, drag on a shaft) and in
shunt (leakage, a strain that is not given back). With Γ = √((Ls+R)(Cs+G)) and
ξ = √((Ls+R)/(Cs+G)), its two ends are bound by a matrix that the paper writes twice:

    [u₀]     [ w        −√(w²−1) ] [y₀]         1     [ 1+x    −2x^½  ] [y₀]
    [u₁] = ξ [ √(w²−1)  −w       ] [y₁]  = ξ ─────── [ 2x^½   −(1+x) ] [y₁]    (12), (13), (15), (17)
                                             (1 − x)
    w = coth Γl = (1+x)/(1−x)        x = z⁻¹ = e^(−2Γl), e^(−s T_p) without losses           (16)

The paper's ξ = √(L/C) is this one where nothing is lost, or where R/L = G/C. Its w alone does not
know the sign of the root: w repeats each half turn of Γl, the root only each whole. x^½ knows it, as e^(−Γl).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vsensor.config import Component
from vsensor.estimator import component

Complexes = NDArray[np.complex128]


@dataclass(frozen=True)
class GeneralLine:
    """A uniform line; all but the length per metre of it, in the SI units of its own u and y."""

    length: float
    inertance: float
    """L: inductance, mass, moment of inertia."""
    compliance: float
    """C: capacitance, compressibility, compliance in twist."""
    series_loss: float = 0.0
    """R."""
    shunt_loss: float = 0.0
    """G."""

    @property
    def delay(self) -> float:
        """θ = l √(LC), s: one way, for the quickest that a signal can be."""
        return float(self.length * np.sqrt(self.inertance * self.compliance))

    def propagation(self, s: ArrayLike) -> Complexes:
        """Γl at complex frequencies s (1/s), in their shape."""
        series, shunt = self._immittances(s)
        return np.asarray(self.length * np.sqrt(series) * np.sqrt(shunt))

    def impedance(self, s: ArrayLike) -> Complexes:
        """ξ, u over y in a wave that only runs down."""
        series, shunt = self._immittances(s)
        return np.asarray(np.sqrt(series) / np.sqrt(shunt))

    def w_form(self, s: ArrayLike) -> Complexes:
        """Eq. (13): ends' u from ends' y, shape (..., 2, 2)."""
        gamma = self.propagation(s)
        w: Complexes = np.reciprocal(np.tanh(gamma))
        root = np.sqrt(w * w - 1)
        root = np.where((root * np.sinh(gamma)).real < 0, -root, root)  # it is 1/sinh Γl, or less that
        return self._matrix(s, w, root)

    def z_form(self, s: ArrayLike) -> Complexes:
        """Eq. (15) and (17): the same by delays, shape (..., 2, 2)."""
        half = np.exp(-self.propagation(s))
        x = half * half
        return self._matrix(s, (1 + x) / (1 - x), 2 * half / (1 - x))

    def chain(self, s: ArrayLike) -> Complexes:
        """(u, y) at the bottom from (u, y) at the top, shape (..., 2, 2): lines in a row multiply."""
        gamma, xi = self.propagation(s), self.impedance(s)
        cosh, sinh = np.cosh(gamma), np.sinh(gamma)
        return _stacked(cosh, -xi * sinh, -sinh / xi, cosh)

    def _immittances(self, s: ArrayLike) -> tuple[Complexes, Complexes]:
        at = np.asarray(s, dtype=np.complex128)
        return self.inertance * at + self.series_loss, self.compliance * at + self.shunt_loss

    def _matrix(self, s: ArrayLike, w: Complexes, root: Complexes) -> Complexes:
        xi = self.impedance(s)
        return _stacked(xi * w, -xi * root, xi * root, -xi * w)


def _stacked(a: Complexes, b: Complexes, c: Complexes, d: Complexes) -> Complexes:
    return np.stack([np.stack([a, b], axis=-1), np.stack([c, d], axis=-1)], axis=-2)


def shaft(part: Component) -> GeneralLine:
    """A shaft: u torque, y speed, R its viscous drag on the wall (above eq. 14, its L and C put right)."""
    moment = component.polar_moment(part)
    return GeneralLine(
        part.length, part.density * moment, 1 / (part.shear_modulus * moment), part.viscous_friction
    )


def cable(
    length: float, inductance: float, capacitance: float, resistance: float, conductance: float
) -> GeneralLine:
    """A pair of wires: u voltage, y current, eq. (4) to (9); H, F, Ω and S per metre."""
    return GeneralLine(length, inductance, capacitance, resistance, conductance)


def hose(length: float, bore: float, density: float, sound_speed: float, viscosity: float) -> GeneralLine:
    """A liquid in a pipe of `bore` (m): u pressure, y volume flow; R of slow flow (Hagen, Poiseuille)."""
    area = np.pi / 4 * bore**2
    return GeneralLine(
        length,
        inertance=density / area,
        compliance=area / (density * sound_speed**2),
        series_loss=8 * np.pi * viscosity / area**2,
    )
