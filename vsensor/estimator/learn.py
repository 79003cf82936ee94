"""The load law, learned while running from the bit's own confirmed torque and speed.

For each of a few Stribeck speeds the law is linear in its other three numbers, with e = e^(−ω/ω_s):
T = D ω + T_k (1 − e) + T_s e.
Weighted least squares with forgetting keeps their sums; the Stribeck speed whose fit is best wins.
A stick tells the static torque: the most that the bit withstood before it broke loose.
Outliers weigh less (Huber 1964), no number may turn negative (coordinate descent, as in Franc,
Hlaváč and Navara 2005), and what the data does not tell stays as it was.
The sums are kept twice, over a minute and over the last seconds in which the bit slid: where these show that
weight on bit or rock have changed, they take the place of the former.
"""

import math
from typing import NamedTuple

import numpy as np

from vsensor.config import Bit
from vsensor.estimator.load import Load
from vsensor.estimator.sections import Floats, Integers
from vsensor.jit import compiled, inlined

STRIBECK_SPEEDS = np.array([0.2 * 25.0 ** (i / 8) for i in range(9)])
"""Candidates, rad/s: 2 to 48 rpm, each half as fast again as the one before."""

SLIDING = 1.5
"""Above this speed (rad/s) the bit surely slides: it is confirmed with a deviation of 0.1 to 0.2 rad/s, and
where it stops or starts the gains, those of a bit that slides, leave some more."""
STICK_S = 0.3
"""A stop of so long is a stick, shorter ones are turning points."""
STICK_WEIGHT_S = 1.0
"""A stick counts as much as so many seconds of sliding, or as it lasted if shorter."""
MEMORY_S = 60.0
"""Time over which what was learned is forgotten: rock changes within minutes."""
LATELY_S = 3.0
"""The shorter memory, of time in which the bit slid: an abrupt change shows within it, and whims of the rock
cancel out."""
ONE_SIDED = 0.5
"""The law has changed where the mean residual of late makes up such a share of the mean square,"""
SHIFTED = 1.2
"""and is so many times what is usual (rms). By chance it is a third: the rock forgets within 0.3 s."""
INERTIA_S = 1.0
"""So many seconds of data weigh as much as staying with the present law."""
TYPICAL_SPEED = 10.0
"""rad/s: makes a change of viscous friction comparable with one of torque."""
HUBER = 1.5
"""Residuals beyond so many typical ones count by their size, not its square."""
EVERY_S = 0.1
"""How often the law is worked out anew."""
CONVINCED = 0.98
"""Another Stribeck speed is taken up only where it leaves less than this share of the squared residual."""
SWEEPS = 40

VISCOUS, KINETIC, STATIC = range(3)
LONG, LATE = range(2)
"""The two memories."""


class Learned(NamedTuple):
    """What is kept; C candidates."""

    law: Floats
    """The law in force: viscous, kinetic, static, Stribeck speed, shape (4,)."""
    speeds: Floats
    """The Stribeck speeds in the contest, the configured one among them, shape (C,)."""
    normal: Floats
    """Sums of weighted products of the regressors in each memory, shape (2, C, 3, 3),"""
    right: Floats
    """of regressors and torque, shape (2, C, 3),"""
    square: Floats
    """of torque squared, shape (2,)."""
    fits: Floats
    """Each candidate's numbers, shape (C, 3)."""
    scale: Floats
    """The typical residual, N·m; then the most torque withstood in the present stop, N·m; shape (2,)."""
    stop: Integers
    """Ticks of the present stop, and the candidate in force, shape (2,)."""
    idle: Integers
    """Whether the bit meets rock (setdown.py), and ticks for which nothing is learned of it, shape (2,)."""


def fresh_law(bit: Bit) -> Learned:
    """The configured first guess, nothing learned yet."""
    candidates = len(STRIBECK_SPEEDS)
    nearest = int(np.argmin(np.abs(np.log(STRIBECK_SPEEDS / bit.stribeck_speed))))
    guess = np.array([bit.viscous_friction, bit.kinetic_torque, bit.static_torque])
    speeds = STRIBECK_SPEEDS.copy()
    speeds[nearest] = bit.stribeck_speed
    return Learned(
        speeds=speeds,
        law=np.array([bit.viscous_friction, bit.kinetic_torque, bit.static_torque, bit.stribeck_speed]),
        normal=np.zeros((2, candidates, 3, 3)),
        right=np.zeros((2, candidates, 3)),
        square=np.zeros(2),
        fits=np.tile(guess, (candidates, 1)),
        scale=np.array([max(bit.kinetic_torque, 100.0), 0.0]),
        stop=np.array([0, nearest]),
        idle=np.zeros(2, np.int64),
    )


@compiled
def load_in_force(learned: Learned, inertia_rate: float) -> Load:
    """The law as the kernels take it; none while the bit meets nothing."""
    if learned.idle[0]:
        return Load(0.0, 0.0, 0.0, 1.0, inertia_rate)
    law = learned.law
    return Load(float(law[0]), float(law[1]), float(law[2]), float(law[3]), inertia_rate)


@compiled
def learn(learned: Learned, held: float, speed: float, torque: float, rate: float, tick: int) -> None:
    """Take one confirmed pair of bit speed and torque.

    Of the torque `held` (N·m) may be held by resting parts of the wall, and need not be by the bit.
    """
    _forget(learned, LONG, math.exp(-1 / (MEMORY_S * rate)))
    if abs(speed) > SLIDING:
        _forget(learned, LATE, math.exp(-1 / (LATELY_S * rate)))
        if learned.stop[0] >= STICK_S * rate:
            weight = min(float(learned.stop[0]), STICK_WEIGHT_S * rate)
            _add(learned, 0.0, learned.scale[1], weight)
        lose_sight(learned)
        _slide(learned, abs(speed), math.copysign(torque, torque * speed), rate)
    else:
        learned.stop[0] += 1
        learned.scale[1] = max(learned.scale[1], abs(torque) - held)
    if tick % max(1, int(EVERY_S * rate)) == 0:
        if _has_changed(learned, INERTIA_S * rate):
            _begin_anew(learned)
        _work_out(learned, INERTIA_S * rate)


@compiled
def lose_sight(learned: Learned) -> None:
    """Forget the stop under way: what the bit withstands while it is not seen belongs to no stick."""
    learned.stop[0] = 0
    learned.scale[1] = 0.0


@inlined
def _forget(learned: Learned, memory: int, share: float) -> None:
    for c in range(learned.speeds.shape[0]):
        for i in range(3):
            learned.right[memory, c, i] *= share
            for j in range(3):
                learned.normal[memory, c, i, j] *= share
    learned.square[memory] *= share


@inlined
def _has_changed(learned: Learned, least: float) -> bool:
    """Whether what the law left over of late is of one sign, and more than is usual: a shift, no scatter."""
    chosen = learned.stop[1]
    p, normal, right = learned.fits[chosen], learned.normal[LATE, chosen], learned.right[LATE, chosen]
    weight = _weight(normal)
    left = right[KINETIC] + right[STATIC]
    for i in range(3):
        left -= p[i] * (normal[i, KINETIC] + normal[i, STATIC])
    of_mean = left * left
    if weight < least or of_mean < ONE_SIDED * weight * _residual(learned, LATE, chosen):
        return False
    usual, weight_long = _residual(learned, LONG, chosen), _weight(learned.normal[LONG, chosen])
    return bool(of_mean * weight_long > SHIFTED * SHIFTED * weight * weight * usual)


@inlined
def weight_of(learned: Learned) -> float:
    """How many ticks of sliding the law rests on."""
    return _weight(learned.normal[LONG, learned.stop[1]])


@inlined
def _weight(normal: Floats) -> float:
    """The sum of all weights: the regressors 1 − e and e add up to 1."""
    return float(normal[KINETIC, KINETIC] + 2.0 * normal[KINETIC, STATIC] + normal[STATIC, STATIC])


@inlined
def _begin_anew(learned: Learned) -> None:
    """Forget all but the last seconds. Element by element: no array is allocated in a kernel."""
    for c in range(learned.speeds.shape[0]):
        for i in range(3):
            learned.right[LONG, c, i] = learned.right[LATE, c, i]
            for j in range(3):
                learned.normal[LONG, c, i, j] = learned.normal[LATE, c, i, j]
    learned.square[LONG] = learned.square[LATE]


@inlined
def _slide(learned: Learned, speed: float, torque: float, rate: float) -> None:
    viscous, kinetic, static, stribeck = learned.law
    expected = viscous * speed + kinetic + (static - kinetic) * math.exp(-speed / stribeck)
    miss = abs(torque - expected)
    limit = HUBER * learned.scale[0]
    _add(learned, speed, torque, 1.0 if miss <= limit else limit / miss)
    gain = 1 / (INERTIA_S * rate)
    learned.scale[0] += gain * (1.25 * min(miss, 2 * limit) - learned.scale[0])


@inlined
def _add(learned: Learned, speed: float, torque: float, weight: float) -> None:
    for c in range(learned.speeds.shape[0]):
        fallen = math.exp(-speed / learned.speeds[c])
        row = (speed, 1.0 - fallen, fallen)
        for i in range(3):
            _add_both(learned.right[:, c, i], weight * row[i] * torque)
            for j in range(3):
                _add_both(learned.normal[:, c, i, j], weight * row[i] * row[j])
    _add_both(learned.square, weight * torque * torque)


@inlined
def _add_both(sums: Floats, more: float) -> None:
    sums[LONG] += more
    sums[LATE] += more


@inlined
def _work_out(learned: Learned, inertia: float) -> None:
    chosen = learned.stop[1]
    best = chosen
    for c in range(learned.speeds.shape[0]):
        _fit(learned, c, inertia)
    for c in range(learned.speeds.shape[0]):
        if _residual(learned, LONG, c) < _residual(learned, LONG, best):
            best = c
    # The bit must have been slow for a while, by the measure of either, before they can be told apart.
    slow = min(learned.normal[LONG, best, STATIC, STATIC], learned.normal[LONG, chosen, STATIC, STATIC])
    if slow > inertia and _residual(learned, LONG, best) < CONVINCED * _residual(learned, LONG, chosen):
        chosen = best
    learned.stop[1] = chosen
    for i in range(3):
        learned.law[i] = learned.fits[chosen, i]
    learned.law[3] = learned.speeds[chosen]


@inlined
def _fit(learned: Learned, c: int, inertia: float) -> None:
    """Least squares over numbers that are not negative, held back by those of before."""
    p = learned.fits[c]
    a = learned.normal[LONG, c]
    stay = (inertia * TYPICAL_SPEED**2, inertia, inertia)
    right = learned.right[LONG, c]
    pull = (right[0] + stay[0] * p[0], right[1] + stay[1] * p[1], right[2] + stay[2] * p[2])
    for _ in range(SWEEPS):
        moved = False
        for i in range(3):
            rest = pull[i]
            for j in range(3):
                if j != i:
                    rest -= a[i, j] * p[j]
            least = p[KINETIC] if i == STATIC else 0.0  # what slides holds at rest
            best = max(least, rest / (a[i, i] + stay[i]))
            moved |= best != p[i]
            p[i] = best
        if not moved:  # nor would any other
            break


@inlined
def _residual(learned: Learned, memory: int, c: int) -> float:
    p = learned.fits[c]
    total = learned.square[memory]
    for i in range(3):
        total -= 2 * p[i] * learned.right[memory, c, i]
        for j in range(3):
            total += p[i] * p[j] * learned.normal[memory, c, i, j]
    # Below this share of the torque a residual is the rounding of these sums.
    return float(max(total, 1e-6 * learned.square[memory]))
