"""A well in software that shares nothing with the sensor: the torsional wave equation on a fine grid.

Speeds live at nodes, torques halfway between them, and either is stepped from the other (leapfrog), both of
second order in step and grid. Cells are as long as a wave runs in a step, or a little longer, so that waves
keep their shape. Downwards: torque is what the string above puts on the string below, in N·m.

    ∂T/∂t = −GJ ∂ω/∂x        ρJ ∂ω/∂t = −∂T/∂x − c ω − F(ω)
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEP_S = 1e-4
"""No step is longer, but where a string would have more than `MOST_CELLS` of them,"""
MOST_CELLS = 3000
"""about a metre each at three kilometres."""
SURE, CLOSE = 30, 1e-12
"""Iterations after which the bit's speed is taken as it is, and the share of it that ends them."""

GONE = 40.0
"""At so many times the speed with which it falls, nothing is left of static friction."""


class Part(NamedTuple):
    """A component of the string, SI; friction per metre of its length."""

    length: float
    ro: float
    ri: float
    c: float = 0.0
    """Viscous, N·m·s/rad."""
    fs: float = 0.0
    """Coulomb torque that holds it at rest, N·m,"""
    fd: float | None = None
    """and while it turns; the same where it is not told."""
    rho: float = 7850.0
    G: float = 79.3e9

    @property
    def moment(self) -> float:
        """Polar second moment of area, m⁴."""
        return math.pi / 2 * (self.ro**4 - self.ri**4)

    @property
    def travel_s(self) -> float:
        """Of a wave from end to end."""
        return self.length * math.sqrt(self.rho / self.G)


class Law(NamedTuple):
    """What rock takes of the bit at a speed, N·m: viscous part, and friction that falls with speed."""

    viscous: float = 0.0
    kinetic: float = 0.0
    static: float = 0.0
    stribeck: float = 1.0
    regular: float = 0.05
    """Below about this speed, rad/s, friction takes what is asked of it."""


class Drive(NamedTuple):
    """A speed controller: proportional and integral, which stands still while the motor is at its limit."""

    kp: float
    ki: float
    limit: float


class Well(NamedTuple):
    """All that is simulated, SI. Lines through points (time, value, …) hold on beyond their ends."""

    string: tuple[Part, ...]
    """From the top drive down."""
    command: tuple[tuple[float, float], ...]
    """Set-point of speed; where there is no drive, the torque at the string's top."""
    law: tuple[tuple[float, Law], ...]
    drive: Drive | None = None
    drive_inertia: float = 0.0
    bit_inertia: float = 0.0
    rock: tuple[float, float] = (0.0, 1.0)
    """Standard deviation and correlation time of what a turning bit meets beside the law."""
    swing: tuple[float, float] = (0.0, 1.0)
    """Share and frequency (Hz) by which the weight on the bit, and with it friction, swings."""
    torque_noise: float = 0.0
    speed_noise: float = 0.0
    torque_lag: float = 0.0
    wall_fade: float = 0.05
    """From static to kinetic the wall's friction falls with this speed, rad/s."""
    duration: float = 60.0
    rate: float = 100.0


class Record(NamedTuple):
    """What is measured above and true below, shape (n,) each, from one sample period on."""

    time: Floats
    motor_torque: Floats
    motor_speed: Floats
    bit_torque: Floats
    bit_speed: Floats


class _Grid(NamedTuple):
    """The string with both its ends: n cells, n + 1 nodes."""

    stiffness: Floats
    """Torque that a cell gains in a step by a difference of speed between its ends, shape (n,)."""
    mass: Floats
    """Inertia over the step, shape (n + 1,), as all below."""
    viscous: Floats
    static: Floats
    kinetic: Floats


class _Plan(NamedTuple):
    """What is done to the string, one value a step."""

    command: Floats
    rock: Floats
    weight: Floats


def simulate(well: Well, seed: int = 1, step_s: float | None = None) -> Record:
    """Run a well; the same seed draws the same noise. A step is the longest, not over `step_s`, that fits."""
    each = math.ceil(1 / (well.rate * (step_s or longest_step(well.string))))
    samples = round(well.duration * well.rate)
    step = 1 / (well.rate * each)
    random = np.random.default_rng(seed)
    plan = _planned(well, np.arange(1, samples * each + 1) / (well.rate * each), random)
    top = np.array([*(well.drive or (0.0, 0.0, 0.0)), well.torque_lag, well.drive is not None])
    laws = np.array([(since, *law) for since, law in well.law])
    out = np.empty((4, samples))
    _run(_grid(well, step), plan, top, laws, well.wall_fade, step, each, out)
    out[0] += well.torque_noise * random.standard_normal(samples)
    out[1] += well.speed_noise * random.standard_normal(samples)
    return Record(np.arange(1, samples + 1) / well.rate, *out)


def longest_step(string: tuple[Part, ...]) -> float:
    """The step that a string is run with: a wave runs through no component within one."""
    travels = [part.travel_s for part in string]
    return min(max(STEP_S, sum(travels) / MOST_CELLS), *travels)


def _planned(well: Well, when: Floats, random: np.random.Generator) -> _Plan:
    std, memory = well.rock
    share, hertz = well.swing
    fall = math.exp(-(when[1] - when[0]) / memory)
    rock = random.standard_normal(len(when)) if std else np.zeros(len(when))
    _remember(rock, fall)
    command = np.interp(when, *np.array(well.command).T)
    return _Plan(command, std * rock, 1 + share * np.sin(2 * np.pi * hertz * when))


def _grid(well: Well, step: float) -> _Grid:
    stiffness: list[float] = []
    nodes = np.zeros((4, 1))
    for part in well.string:
        cells = max(1, int(part.travel_s / step * (1 + 1e-9)))
        dx = part.length / cells
        stiffness += [part.G * part.moment * step / dx] * cells
        kinetic = part.fs if part.fd is None else part.fd
        half = np.array([part.rho * part.moment / step, part.c, part.fs, kinetic])[:, None] * dx / 2
        here = np.hstack([half, np.tile(2 * half, cells - 1), half])
        nodes = np.hstack([nodes[:, :-1], nodes[:, -1:] + here[:, :1], here[:, 1:]])
    nodes[0, 0] += well.drive_inertia / step
    nodes[0, -1] += well.bit_inertia / step
    # The bit has a law of its own: what the wall takes of its half cell it does one node further up.
    nodes[2:, -2] += nodes[2:, -1]
    return _Grid(np.array(stiffness), *(np.ascontiguousarray(row) for row in nodes))


@njit(cache=True)
def _remember(noise: Floats, fall: float) -> None:
    """Turn white noise of unit variance into a first-order process of the same, in its place."""
    kick = math.sqrt(1 - fall**2)
    for n in range(1, len(noise)):
        noise[n] = fall * noise[n - 1] + kick * noise[n]


@njit(cache=True)
def _run(
    grid: _Grid, plan: _Plan, top: Floats, laws: Floats, fade: float, step: float, each: int, out: Floats
) -> None:
    """Fill `out` (motor torque and speed, bit torque and speed; by sample) with each `each`-th step."""
    kp, ki, limit, lag, controlled = top
    follow = 1 - math.exp(-step / lag) if lag > 0 else 1.0
    # What stays the same of a node in a step, and what a torque gives it: friction acts on the mean speed.
    keep, give = grid.mass - grid.viscous / 2, 1 / (grid.mass + grid.viscous / 2)
    speed, torque = np.zeros(len(grid.mass)), np.zeros(len(grid.stiffness))
    falls = bool(np.any(grid.static > grid.kinetic))
    turning = grid.kinetic * give
    grip = turning.copy()
    rises = (grid.static - grid.kinetic) * give
    integral, reported, at_bit = 0.0, 0.0, 0.0
    for n in range(len(plan.command)):
        _twist(torque, speed, grid.stiffness)
        motor = plan.command[n]
        if controlled:
            miss = motor - speed[0]
            wanted = kp * miss + integral
            motor = min(max(wanted, -limit), limit)
            if motor == wanted:
                integral += ki * miss * step
        reported += follow * (motor - reported)
        before = speed[0]
        if falls:
            _grip(grip, speed, turning, rises, fade)
        speed[0] = _rubbed((keep[0] * speed[0] + motor - torque[0]) * give[0], grip[0])
        for k in range(1, len(torque)):
            speed[k] = _rubbed((keep[k] * speed[k] + torque[k - 1] - torque[k]) * give[k], grip[k])
        law = _law_at(laws, (n + 1) * step)
        twice = 2 * grid.mass[-1]
        pull = twice * speed[-1] + torque[-1]
        at_bit = _bit_speed(law, plan.weight[n], plan.rock[n], pull, twice + grid.viscous[-1], at_bit)
        speed[-1] = 2 * at_bit - speed[-1]
        if (n + 1) % each == 0:
            k = n // each
            out[0, k], out[1, k] = reported, (before + speed[0]) / 2
            out[2, k], out[3, k] = _rub(law, plan.weight[n], plan.rock[n], at_bit)[0], at_bit


@njit(cache=True)
def _twist(torque: Floats, speed: Floats, stiffness: Floats) -> None:
    for k in range(len(torque)):
        torque[k] += stiffness[k] * (speed[k] - speed[k + 1])


@njit(cache=True)
def _grip(grip: Floats, speed: Floats, turning: Floats, rises: Floats, fade: float) -> None:
    """What the wall can take of each node's speed in a step."""
    for k in range(len(speed) - 1):
        grip[k] = turning[k]
        if abs(speed[k]) < GONE * fade:
            grip[k] += rises[k] * math.exp(-abs(speed[k]) / fade)


@njit(cache=True)
def _rubbed(free: float, grip: float) -> float:
    """The speed of a node that would be `free` without the wall, which can take `grip`, or stop it."""
    taken = grip if free > grip else free
    return free - (-grip if taken < -grip else taken)


@njit(cache=True)
def _law_at(laws: Floats, now: float) -> Floats:
    """Values of `Law` at a time, from rows of (time, values)."""
    last = len(laws) - 1
    k = 0
    while k < last and laws[k + 1, 0] <= now:
        k += 1
    if k == last:
        return laws[k, 1:]
    share = max(0.0, now - laws[k, 0]) / (laws[k + 1, 0] - laws[k, 0])
    law: Floats = laws[k, 1:] + share * (laws[k + 1, 1:] - laws[k, 1:])
    return law


@njit(cache=True)
def _rub(law: Floats, weight: float, rock: float, speed: float) -> tuple[float, float]:
    """Torque that the rock takes at a speed, and its slope; however rough, it never drives the bit."""
    viscous, kinetic, static, stribeck, regular = law
    more = weight * (static - kinetic) * math.exp(-abs(speed) / stribeck)
    whole = weight * kinetic + more + rock
    if whole <= 0:
        return viscous * speed, viscous
    sliding = math.tanh(speed / regular)
    slope = whole * (1 - sliding**2) / regular - more * abs(sliding) / stribeck
    return viscous * speed + whole * sliding, viscous + slope


@njit(cache=True)
def _bit_speed(law: Floats, weight: float, rock: float, pull: float, mass: float, guess: float) -> float:
    """The speed amid a step at which mass · speed + rock's torque = pull: Newton's, kept between bounds."""
    low, high = min(0.0, pull / mass), max(0.0, pull / mass)
    speed = min(max(guess, low), high)
    for _ in range(SURE):
        taken, slope = _rub(law, weight, rock, speed)
        over = mass * speed + taken - pull
        if over > 0:
            high = speed
        else:
            low = speed
        last, speed = speed, speed - over / (mass + slope)
        if not low <= speed <= high:
            speed = (low + high) / 2
        if abs(speed - last) <= CLOSE * abs(speed):
            break
    return speed
