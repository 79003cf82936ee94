"""Naive twins of the kernels: the equations of docs/theory in plain Python, a page, slow and plain to see."""

import math
from collections import deque
from collections.abc import Callable, Sequence

from vsensor.estimator.line import FADE_SPEED
from vsensor.estimator.load import Load
from vsensor.estimator.sections import Line


def descend(line: Line, torques: Sequence[float], speeds: Sequence[float]) -> list[tuple[float, float]]:
    """Torque and speed at the bottom for each step of them at the top, from a string without waves."""
    queues = [deque([0.0] * n) for n in line.round_trip]
    return [_peel(line, queues, t, w) for t, w in zip(torques, speeds, strict=True)]


def _peel(line: Line, queues: list[deque[float]], torque: float, speed: float) -> tuple[float, float]:
    torque -= friction(line, 0, speed)
    for i, queue in enumerate(queues):
        z = line.impedance[i]
        f, g = torque + z * speed, torque - z * speed
        queue.append(f)
        f = queue.popleft()
        torque, speed = (f + g) / 2, (f - g) / (2 * z)
        torque -= friction(line, i + 1, speed)
    return torque, speed


def friction(line: Line, junction: int, speed: float) -> float:
    share = max(-1.0, min(1.0, speed / FADE_SPEED))
    return float(line.viscous[junction] * speed + line.kinetic[junction] * share)


class Cells:
    """A string at rest, turned at its top against a drag at its bottom: both waves in every cell of it.

    In real time, as it is: f moves one cell down at each step, g one up. Its friction is viscous.
    """

    def __init__(self, line: Line, drag: float) -> None:
        self.line, self.drag = line, drag
        self.f = [[0.0] * (n // 2 + 1) for n in line.round_trip.tolist()]
        self.g = [[0.0] * (n // 2 + 1) for n in line.round_trip.tolist()]

    def step(self, speed: float) -> float:
        """Torque at the top."""
        z, rub = self.line.impedance.tolist(), self.line.viscous.tolist()
        self.f = [[0.0, *f[:-1]] for f in self.f]
        self.g = [[*g[1:], 0.0] for g in self.g]
        self.f[0][0] = self.g[0][0] + 2 * z[0] * speed
        for i in range(1, len(z)):
            w = (self.f[i - 1][-1] - self.g[i][0]) / (z[i - 1] + z[i] + rub[i])
            self.f[i][0] = self.g[i][0] + 2 * z[i] * w
            self.g[i - 1][-1] = self.f[i - 1][-1] - 2 * z[i - 1] * w
        w = self.f[-1][-1] / (z[-1] + rub[-1] + self.drag)
        self.g[-1][-1] = self.f[-1][-1] - 2 * z[-1] * w
        return float(self.g[0][0] + (z[0] + rub[0]) * speed)

    def at(self, section: int, cell: int) -> tuple[float, float]:
        """Speed and torque in a cell, its section's friction spread evenly."""
        f, g = self.f[section][cell], self.g[section][cell]
        w = (f - g) / (2 * self.line.impedance[section])
        share, last = cell / (len(self.f[section]) - 1), len(self.f) - 1
        above = friction(self.line, section, w) * (1.0 if section == 0 else 0.5)
        below = friction(self.line, section + 1, w) * (1.0 if section == last else 0.5)
        return w, (f + g) / 2 + (1 - share) * above - share * below


class Forward:
    """A string at rest, driven by torque at its top: every junction's balance solved by bisection."""

    def __init__(self, line: Line, load: Load, top_rate: float) -> None:
        self.line, self.load, self.top_rate = line, load, top_rate
        self.queues = [deque([0.0] * n) for n in line.round_trip]
        self.speeds = [0.0] * (len(line.impedance) + 1)
        self.top_balance = self.bit_balance = 0.0

    def step(self, torque: float) -> tuple[float, float, float]:
        """Top speed, bit speed and bit torque."""
        line, last = self.line, len(self.line.impedance)
        arrived = [queue.popleft() for queue in self.queues]
        before, rate = self.speeds[last], self.load.inertia_rate
        drive = arrived[-1] + rate * before + self.bit_balance
        bit = balance(
            drive,
            rate + line.impedance[-1] + line.viscous[last],
            lambda w: line.kinetic[last] + coulomb(self.load, w) + self.load.viscous * w,
            (line.static[last] if before == 0 else line.kinetic[last]) + self.load.static,
        )
        self.bit_balance = 0.0 if bit == 0 else rate * (bit - before) - self.bit_balance
        bit_torque = law(self.load, bit) if bit else arrived[-1]
        self.speeds[last] = bit
        g = arrived[-1] - 2 * line.impedance[-1] * bit
        for i in range(last - 1, 0, -1):
            above, below = line.impedance[i - 1], line.impedance[i]
            w = self._junction(i, arrived[i - 1] - g, above + below)
            self.queues[i].append(g + 2 * below * w)
            g = arrived[i - 1] - 2 * above * w
        before = self.speeds[0]
        drive = torque - g + self.top_rate * before + self.top_balance
        top = self._junction(0, drive, self.top_rate + line.impedance[0])
        self.top_balance = self.top_rate * (top - before) - self.top_balance if top else 0.0
        self.queues[0].append(g + 2 * line.impedance[0] * top)
        return top, bit, bit_torque

    def _junction(self, i: int, drive: float, resistance: float) -> float:
        held = self.line.static[i] if self.speeds[i] == 0 else self.line.kinetic[i]
        kinetic = float(self.line.kinetic[i])
        w = balance(drive, resistance + self.line.viscous[i], lambda _: kinetic, held)
        self.speeds[i] = w
        return w


def coulomb(load: Load, speed: float) -> float:
    return load.kinetic + (load.static - load.kinetic) * math.exp(-speed / load.stribeck)


def law(load: Load, speed: float) -> float:
    return load.viscous * speed + math.copysign(coulomb(load, abs(speed)), speed)


def balance(drive: float, resistance: float, rubbing: Callable[[float], float], held: float) -> float:
    """The speed w at which resistance·w + rubbing(|w|)·sign w = drive; 0 where friction holds."""
    if abs(drive) <= held:
        return 0.0
    low, high = 0.0, abs(drive) / resistance
    for _ in range(200):
        middle = (low + high) / 2
        if resistance * middle + rubbing(middle) > abs(drive):
            high = middle
        else:
            low = middle
    return math.copysign(low, drive)
