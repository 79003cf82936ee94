"""Stick-slip of the lumped string, section III of the paper.

The paper says that pipe is "caught by friction in contrast to the borehole and then release[d]",
that relays switch it, that the bit swings between 0 and 0.8 rad/s under 7000 N·m, and that 9000 N·m
end it. It gives no law and no value. What follows is ours, and takes the paper's sentence at its word:

    at rest    sticktion holds the bit until the shaft's torque passes STICKTION;
    free       it turns against FREE;
    caught     from CATCH_SPEED on it is caught, and turns against CAUGHT until it is at rest.

A relay with two switching points, as in the paper's Fig. 3, beside the viscous drag C_b of eq. (1).
Between them the string is linear.

Why not a friction that merely falls with speed, as in every textbook? Because this string cannot swing
by it. Falling friction is a negative drag on the bit. Past C_r + C_b = 400 N·m·s/rad of it the mean
speed runs away, but the swing of the two inertias against each other dies out however steep the fall
(`growth`): with J_b > J_r the bit moves little in that swing, and c damps it well.
"""

import numpy as np

from vsensor.paper.chain import TOLERANCE, Chain, Exit, Motion, Regime, simulate
from vsensor.paper.lumped import Lumped, state_space
from vsensor.paper.shaft import Floats

STICKTION = 7100.0
"""What holds the bit at rest, N·m: more than the motor's 7000, so that the swing of the pipe above must
wind the shaft up beyond it. With 7000 and less the bit only touches zero and goes on; with 7200 it stays."""

FREE = 6000.0
"""Coulomb friction of the bit while nothing has caught it, N·m."""

CAUGHT = 8000.0
"""Coulomb friction of the bit while caught, N·m: it brings the bit to rest against 7000, not against 9000."""

CATCH_SPEED = 0.8
"""The speed from which on the bit is caught, rad/s: the paper's amplitude."""


def relay(sticktion: float = STICKTION) -> dict[str, Regime]:
    """The law above, with what holds the bit at rest (N·m); ValueError for less than it turns against."""
    if sticktion < FREE:
        raise ValueError(f"sticktion {sticktion:g} N·m must be at least FREE, {FREE:g} N·m")
    return {
        "held": Regime(None, (Exit(lambda t, _: t - sticktion * (1 + TOLERANCE), "free"),)),
        "free": Regime(
            lambda _: FREE, (Exit(lambda _, w: -w, "held"), Exit(lambda _, w: w - CATCH_SPEED, "caught"))
        ),
        "caught": Regime(lambda _: CAUGHT, (Exit(lambda _, w: -w, "held"),)),
    }


def chain_of(model: Lumped) -> Chain:
    """The lumped string of eq. (1) as a chain of two inertias."""
    return Chain(
        inertia=np.array([model.J_r, model.J_b]),
        stiffness=np.array([model.k]),
        damping=np.array([model.c]),
        drag=np.array([model.C_r, model.C_b]),
    )


def drill(model: Lumped, torque: float, until: float, sticktion: float = STICKTION) -> Motion:
    """From rest under a constant torque (N·m), the bit against the relay, to `until` (s)."""
    return simulate(chain_of(model), relay(sticktion), torque, until)


def growth(model: Lumped, slope: float) -> Floats:
    """The three eigenvalues of eq. (1), 1/s, with a friction at the bit that falls by `slope` N·m·s/rad."""
    a, _, _ = state_space(model._replace(C_b=model.C_b - slope))
    return np.asarray(np.linalg.eigvals(a))
