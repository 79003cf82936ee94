"""The distributed-lumped drill string, eq. (18) to (25): difference equations.

The load between two samples is exact for a torque that holds, so with α = e^(−D h/J), β = (1 − α)/D,
h the step and y = z⁻¹ the delay of one step

    ω₁/T₁ = β / (1 − α y)            X_L = T₁/ω₁ = (1 − α y)/β            (18) to (22), mended

The line delays by a round trip x = y^N. (23) solved for the speeds, both multiplied out:

    ω₀/T₀ = [(1 − αy)(1 − x) + ζβ(1 + x)] / ζ[(1 − αy)(1 + x) + ζβ(1 − x)]              (24)
    ω₁/T₀ = 2β x^½                        /  [(1 − αy)(1 + x) + ζβ(1 − x)]              (25)

The paper takes one step for a round trip, N = 1 and y = x: the load is then looked at every T_p,
2.54 s in its example. Nothing forbids a larger N, and it is kept here to show what that costs.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyadd, polymul, polysub
from scipy import signal

from vsensor.config import Component
from vsensor.estimator import component
from vsensor.paper.shaft import Floats, Load, Response, Trace


class LoadRule(NamedTuple):
    """The load stepped: ω₁[n] = α ω₁[n−1] + β T₁[n]."""

    alpha: float
    beta: float


class Difference(NamedTuple):
    """Eq. (24) and (25), ω/T₀, as coefficients of rising powers of y, the delay of one step."""

    top: Floats
    """Numerator of (24)."""
    end: Floats
    """Numerator of (25), without its x^½: the end's samples stand one delay θ later."""
    end_torque: Floats
    """Numerator of T₁/T₀ = X_L ω₁/T₀, without its x^½."""
    denominator: Floats
    step: float
    """One step, s."""
    delay: float
    """θ, s."""


def load_rule(load: Load, step: float) -> LoadRule:
    """α_L and β_L for steps of `step` seconds (below eq. 21)."""
    alpha = math.exp(-load.damping * step / load.inertia)
    return LoadRule(alpha, (1 - alpha) / load.damping)


def difference(shaft: Component, load: Load, steps: int = 1) -> Difference:
    """Eq. (24) and (25) mended, with `steps` steps in a round trip; 1 is the paper's."""
    theta, zeta = component.delay(shaft), component.impedance(shaft)
    step = 2 * theta / steps
    alpha, beta = load_rule(load, step)
    lag = np.array([1.0, -alpha])
    trip = np.eye(steps + 1)[steps]
    one = np.array([1.0])
    plus, minus = polyadd(one, trip), polysub(one, trip)
    return Difference(
        top=polyadd(polymul(lag, minus) / zeta, beta * plus),
        end=np.array([2 * beta]),
        end_torque=2 * lag,
        denominator=polyadd(polymul(lag, plus), zeta * beta * minus),
        step=step,
        delay=theta,
    )


def step_response(model: Difference, torque: float, until: float) -> Response:
    """From rest, a torque (N·m) stepped on at time 0, to `until` (s): the top at n h, the end at θ + n h."""
    count = int(until / model.step) + 1
    drive = np.full(count, torque)
    time: Floats = np.arange(count, dtype=np.float64) * model.step
    later = time + model.delay

    def answer(numerator: Floats, at: Floats) -> Trace:
        return Trace(at, np.asarray(signal.lfilter(numerator, model.denominator, drive)))

    return Response(answer(model.top, time), answer(model.end, later), answer(model.end_torque, later))


def steady_as_printed(shaft: Component, load: Load, torque: float) -> float:
    """Where both speeds settle by (24) and (25) as they are printed, rad/s.

    Their denominators have been divided by 1 + ζβ and their numerators by nothing, and ζ stands on the
    wrong side: they come out by ζ(1 + ζβ) too large, and of no speed's dimension.
    """
    zeta = component.impedance(shaft)
    beta = load_rule(load, 2 * component.delay(shaft)).beta
    return torque / load.damping * zeta * (1 + zeta * beta)
