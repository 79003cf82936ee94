"""The lumped model: two inertias on a damped spring, eq. (1) to (3).

Its string is one spring: what happens at the top is felt at the bit at once, and torque is the same
all along. With the second line of (1) mended it reads

    T_m                     = (J_r s + C_r) φ̇_r + c (φ̇_r − φ̇_b) + k (φ_r − φ_b)
    k (φ_r − φ_b) + c (φ̇_r − φ̇_b) = (J_b s + C_b) φ̇_b                                       (1)
"""

from typing import NamedTuple

import numpy as np
from scipy import signal

from vsensor.config import Component
from vsensor.paper import shaft as paper
from vsensor.paper.shaft import BIT_INERTIA, Floats, Response, Trace


class Lumped(NamedTuple):
    """The parameters of eq. (1), by the paper's names."""

    J_r: float
    """Inertia of the pipe, kg·m²."""
    J_b: float
    """Inertia of collars and bit, kg·m²."""
    k: float
    """Stiffness, N·m/rad."""
    C_r: float = 200.0
    """Drag on the pipe, N·m·s/rad."""
    C_b: float = 200.0
    """Drag on the bit, N·m·s/rad."""
    c: float = 200.0
    """Damping in the spring, N·m·s/rad."""


class TransferFunctions(NamedTuple):
    """Eq. (2) and (3), ω/T_m, as coefficients of falling powers of s."""

    end: Floats
    """Numerator of (2), the bit's."""
    top: Floats
    """Numerator of (3), the top's."""
    denominator: Floats
    """L₁ s³ + L₂ s² + L₃ s + L₄, of both."""


def of_shaft(shaft: Component) -> Lumped:
    """The paper's parameters, inertia and stiffness of the pipe as its length has them."""
    return Lumped(paper.pipe_inertia(shaft), BIT_INERTIA, paper.stiffness(shaft))


def state_space(model: Lumped) -> tuple[Floats, Floats, Floats]:
    """Eq. (1) as ẋ = A x + B T_m, y = C x.

    x = (φ_r − φ_b, φ̇_r, φ̇_b); y = (ω₀, ω₁, torque in the shaft). Shapes (3, 3), (3, 1), (3, 3).
    """
    J_r, J_b, k, C_r, C_b, c = model
    a = np.array(
        [
            [0.0, 1.0, -1.0],
            [-k / J_r, -(C_r + c) / J_r, c / J_r],
            [k / J_b, c / J_b, -(C_b + c) / J_b],
        ]
    )
    b = np.array([[0.0], [1 / J_r], [0.0]])
    return a, b, np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [k, c, -c]])


def transfer_functions(model: Lumped) -> TransferFunctions:
    """Eq. (2) and (3), with T_m multiplying the fraction (the copy has it below the bar in (2))."""
    J_r, J_b, k, C_r, C_b, c = model
    return TransferFunctions(
        end=np.array([c, k]),
        top=np.array([J_b, C_b + c, k]),
        denominator=np.array(
            [
                J_r * J_b,
                J_r * C_b + J_b * C_r + J_b * c + J_r * c,
                J_r * k + J_b * k + C_b * c + C_r * c + C_b * C_r,
                (C_b + C_r) * k,
            ]
        ),
    )


def step_response(model: Lumped, torque: float, time: Floats) -> Response:
    """From rest, the torque stepped on at time 0: exact at each of `time`, evenly spaced from 0.

    The torque is constant, so that one matrix exponential leads from each time to the next.
    """
    a, b, c = state_space(model)
    system = signal.StateSpace(a, b, c, np.zeros((3, 1)))
    _, out, _ = signal.lsim(system, np.full(len(time), torque), time, interp=False)
    return Response(*(Trace(time, np.ascontiguousarray(column)) for column in out.T))
