"""The naive twin of the gains: a Kalman filter of the whole string, every delay a state, by iteration.

The textbook's (Anderson and Moore 1979), in plain NumPy: transition matrices by running the string's
equations on the columns of the unit matrix, and the past kept in the state, which makes the filter a
fixed-lag smoother.
"""

from typing import NamedTuple

import numpy as np

from vsensor.estimator.responses import Plant
from vsensor.estimator.sections import Floats

PAST = ("bit_speed", "bit_torque", "top_speed", "top_torque")


class Columns:
    """Many strings side by side, each a column: `queues` of f, speeds, balances, rock, the last sample."""

    def __init__(self, plant: Plant, lag: int, fade: float) -> None:
        self.plant, self.fade = plant, fade
        trips = plant.line.round_trip.tolist()
        deep = lag * plant.steps
        # Waves are kept beyond what the string needs, so that each correction of them can be looked at.
        self.kept = [max(trip, deep) for trip in trips]
        names = [(f"wave{i}", n) for i, n in enumerate(self.kept)]
        names += [(f"returned{i}", deep) for i in range(len(trips))]
        names += [("speed", len(trips) + 1), ("top_balance", 1), ("bit_balance", 1), ("rock", 1)]
        names += [("sample", 1), *((past, deep) for past in PAST)]
        ends = np.cumsum([size for _, size in names]).tolist()
        self.at = {name: slice(end - size, end) for (name, size), end in zip(names, ends, strict=True)}
        self.size = ends[-1]

    def tick(self, before: Floats, sample: Floats, kick: Floats) -> Floats:
        """One tick of all columns (N, K), each with its torque sample and its kick of the rock (K,)."""
        x = before.copy()
        last, steps = x[self.at["sample"]][0].copy(), self.plant.steps
        for row in range(1, steps + 1):
            x[self.at["rock"]] = self.fade * x[self.at["rock"]] + (kick if row == 1 else 0.0)
            self._step(x, last + (sample - last) * row / steps)
        x[self.at["sample"]] = sample
        return x

    def _step(self, x: Floats, motor: Floats) -> None:
        line, end = self.plant.line, len(self.plant.line.impedance)
        z, rub = line.impedance, line.viscous
        arrived = [x[self.at[f"wave{i}"]][n - 1].copy() for i, n in enumerate(line.round_trip)]
        speed = x[self.at["speed"]]
        rock = x[self.at["rock"]][0].copy()

        def turn(rate: float, drive: Floats, resistance: float, junction: int, balance: str) -> Floats:
            old, held = speed[junction].copy(), x[self.at[balance]][0].copy()
            w = np.asarray((drive + rate * old + held) / (rate + resistance))
            x[self.at[balance]] = rate * (w - old) - held
            speed[junction] = w
            return w

        drag = self.plant.drag
        w = turn(self.plant.bit_rate, arrived[-1] - rock, z[-1] + rub[end] + drag, end, "bit_balance")
        self._push(x, "bit_speed", w)
        self._push(x, "bit_torque", rock + drag * w)
        g = arrived[-1] - 2 * z[-1] * w
        self._push(x, f"returned{end - 1}", g)
        for i in range(end - 1, 0, -1):
            w = (arrived[i - 1] - g) / (z[i - 1] + z[i] + rub[i])
            speed[i] = w
            self._push(x, f"wave{i}", g + 2 * z[i] * w)
            g = arrived[i - 1] - 2 * z[i - 1] * w
            self._push(x, f"returned{i - 1}", g)
        w = turn(self.plant.drive_rate, motor - g, z[0] + rub[0], 0, "top_balance")
        self._push(x, "wave0", g + 2 * z[0] * w)
        self._push(x, "top_speed", w)
        self._push(x, "top_torque", g + (z[0] + rub[0]) * w)

    def _push(self, x: Floats, name: str, newest: Floats) -> None:
        held = x[self.at[name]]
        held[1:] = held[:-1].copy()
        held[0] = newest


class Steady(NamedTuple):
    gain: Floats
    """Of each state by an innovation of 1 rad/s, shape (N,)."""
    innovation: float
    """Variance of the innovation."""
    posterior: Floats
    """Covariance of the states once the newest sample is in, shape (N, N)."""
    transition: Floats
    noise: Floats
    """What a tick adds to the covariance, shape (N, N)."""


def steady(columns: Columns, torque_noise: float, speed_noise: float, kick: float, forgets: float) -> Steady:
    """Iterate until nothing changes; the string is one that keeps the share `forgets` in each tick."""
    n = columns.size
    none = np.zeros(n)
    transition = forgets * columns.tick(np.eye(n), none, none)
    driven = columns.tick(np.zeros((n, 2)), np.array([torque_noise, 0.0]), np.array([0.0, kick]))
    noise = driven @ driven.T
    seen = columns.at["speed"].start
    posterior = np.zeros((n, n))
    for _ in range(20_000):
        prior = transition @ posterior @ transition.T + noise
        innovation = float(prior[seen, seen]) + speed_noise**2
        gain = prior[:, seen] / innovation
        after = prior - np.outer(gain, prior[seen])
        if np.abs(after - posterior).max() <= 1e-12 * np.abs(after).max():
            break
        posterior = after
    return Steady(gain, innovation, after, transition, noise)
