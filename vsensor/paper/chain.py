"""Inertias in a row with dry friction on the last, its events located.

Dry friction changes its law where the bit comes to rest or breaks loose. Stepping over such an instant
makes a simulation chatter, however small the step. Here motion is a sequence of *regimes*, in each of
which everything is smooth: an integrator with error control runs until an exit of the regime crosses
zero, finds that instant by root search, and the next regime starts from there.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from vsensor.paper.shaft import Floats

TOLERANCE = 1e-9
"""Of the integrator, relative; and what a torque must exceed the static one by to count as more."""


class Chain(NamedTuple):
    """n inertias in a row, a driven one first; springs and dampers between them, drag on each."""

    inertia: Floats
    """kg·m², shape (n,)."""
    stiffness: Floats
    """N·m/rad, shape (n − 1,)."""
    damping: Floats
    """Beside each spring, N·m·s/rad, shape (n − 1,)."""
    drag: Floats
    """Viscous, against the ground, N·m·s/rad, shape (n,)."""


Measure = Callable[[float, float], float]
"""Of the last shaft's torque (N·m) and the last inertia's speed (rad/s)."""


class Exit(NamedTuple):
    """Leave a regime when `margin` rises through zero."""

    margin: Measure
    to: str


class Regime(NamedTuple):
    """One way for the last inertia to move; forward, or not at all."""

    friction: Callable[[float], float] | None
    """Torque against it at a speed, N·m; None while it is held at rest."""
    exits: tuple[Exit, ...]


class Event(NamedTuple):
    """A regime was entered."""

    time: float
    regime: str


class Motion(NamedTuple):
    """What came of it, on an even time grid."""

    time: Floats
    """s, shape (m,)."""
    speeds: Floats
    """rad/s, shape (n, m)."""
    torque: Floats
    """In the last shaft, N·m, shape (m,)."""
    events: tuple[Event, ...]

    def times(self, regime: str) -> Floats:
        """When a regime was entered, s."""
        return np.array([event.time for event in self.events if event.regime == regime])


def stribeck(kinetic: float, static: float, speed: float) -> dict[str, Regime]:
    """Friction that holds up to `static`, and falls to `kinetic` (N·m) within a few times `speed` (rad/s)."""

    def sliding(w: float) -> float:
        return kinetic + (static - kinetic) * float(np.exp(-abs(w) / speed))

    return {
        "held": Regime(None, (Exit(lambda t, _: t - static * (1 + TOLERANCE), "sliding"),)),
        "sliding": Regime(sliding, (Exit(lambda _, w: -w, "held"),)),
    }


def simulate(
    chain: Chain, law: Mapping[str, Regime], torque: float, until: float, step: float = 0.01
) -> Motion:
    """From rest, a constant torque (N·m) on the first inertia, to `until` (s), told every `step` (s).

    `law` names the regimes; the motion begins in "held". Turning backwards is in none of them.
    """
    n = len(chain.inertia)
    state, now, regime = np.zeros(2 * n - 1), 0.0, "held"
    events = [Event(now, regime)]
    grid: Floats = np.arange(int(until / step) + 1, dtype=np.float64) * step
    told = np.empty((2 * n - 1, len(grid)))
    while now < until:
        run = _until_exit(chain, law[regime], torque, state, now, until)
        piece = (grid >= now) & (grid <= run.t[-1])
        if piece.any():
            told[:, piece] = run.sol(grid[piece])
        now, state = float(run.t[-1]), run.y[:, -1].copy()
        if now < until:
            regime = _next(chain, law, regime, state)
            events.append(Event(now, regime))
    return Motion(grid, told[n - 1 :], _last_torque(chain, told), tuple(events))


def _until_exit(
    chain: Chain, regime: Regime, torque: float, state: Floats, start: float, until: float
) -> Any:
    def moving(_: float, x: Floats) -> Floats:
        return _rates(chain, regime, torque, x)

    exits = [_crossing(chain, exit_.margin) for exit_ in regime.exits]
    return solve_ivp(
        moving,
        (start, until),
        state,
        method="DOP853",
        events=exits,
        dense_output=True,
        rtol=TOLERANCE,
        atol=TOLERANCE,
    )


def _crossing(chain: Chain, margin: Measure) -> Callable[[float, Floats], float]:
    def crossing(_: float, x: Floats) -> float:
        return margin(float(_last_torque(chain, x)), float(x[-1]))

    crossing.terminal = True  # type: ignore[attr-defined]
    crossing.direction = 1.0  # type: ignore[attr-defined]
    return crossing


def _next(chain: Chain, law: Mapping[str, Regime], regime: str, state: Floats) -> str:
    """The regime behind the exit that was just found; its state is put right where it is to hold."""
    margins = _margins(chain, law[regime], state)
    entered = law[regime].exits[int(np.argmax(margins))].to
    if law[entered].friction is not None:
        return entered
    state[-1] = 0.0
    # What has stopped but cannot be held goes on at once: it has but touched zero.
    return _next(chain, law, entered, state) if max(_margins(chain, law[entered], state)) > 0 else entered


def _margins(chain: Chain, regime: Regime, state: Floats) -> list[float]:
    torque, speed = float(_last_torque(chain, state)), float(state[-1])
    return [exit_.margin(torque, speed) for exit_ in regime.exits]


def _rates(chain: Chain, regime: Regime, torque: float, state: Floats) -> Floats:
    """d/dt of the twists of the n − 1 springs and of the n speeds."""
    springs = len(chain.stiffness)
    speeds = state[springs:]
    slips = speeds[:-1] - speeds[1:]
    shaft = chain.stiffness * state[:springs] + chain.damping * slips
    net = -chain.drag * speeds
    net[0] += torque
    net[:-1] -= shaft
    net[1:] += shaft
    if regime.friction is None:
        net[-1] = 0.0
    else:
        net[-1] -= regime.friction(float(speeds[-1]))
    return np.concatenate([slips, net / chain.inertia])


def _last_torque(chain: Chain, states: Floats) -> Floats:
    last = len(chain.stiffness) - 1
    slip = states[-2] - states[-1]
    return np.asarray(chain.stiffness[last] * states[last] + chain.damping[last] * slip)
