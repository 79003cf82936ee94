"""The waves in the string: up from the bit by a load law, down from the top by what turns it.

Everything runs in slanted time: at internal step k the junction at depth d is seen at the time
k − θ(d), one travel time late. A wave that leaves a section's top at step k then left its bottom
at step k too, so that torque upward costs no delay, and only the wave downward is held: its
round trip 2θ later it stands at the bottom, in the same slanted time. One array holds it all,
`waves[section, step & mask]`, the wave f = T + ζω at the top of each section. (Paper eq. 17, as
mended in docs/theory; the method of characteristics.)
"""

from vsensor.estimator.load import Load, contact, foot, law, turn_bit
from vsensor.estimator.ring import mask_of
from vsensor.estimator.sections import Floats, Line
from vsensor.jit import compiled, inlined

FADE_SPEED = 1.0
"""Below this speed (rad/s) Coulomb friction fades to zero where it is told of a speed that was measured: a
junction at rest may bear any torque up to the static one, and the sign of its noise would throw the full
friction from side to side."""


@inlined
def rubbing(line: Line, junction: int, speed: float) -> float:
    """Friction of a junction that turns at a measured speed, N·m."""
    share = min(1.0, max(-1.0, speed / FADE_SPEED))
    return float(line.viscous[junction] * speed + line.kinetic[junction] * share)


@compiled
def march(
    line: Line,
    load: Load,
    waves: Floats,
    step: int,
    external: float,
    speeds: Floats,
    balance: float,
    told: Floats,
    place: int,
) -> tuple[float, float]:
    """March the string from the bit up by a load law, for one step.

    Enters f of that step into all sections but the top one. `speeds` (M + 1,) and `balance`, J dω/dt of the
    bit, are the state at the step before; the first is replaced. Leaves bit speed and torque in
    `told[:2, place]`. `external` is a further torque on the bit. Returns the wave g that leaves the top, and
    the new balance.
    """
    g, balance = pass_bit(line, load, waves, step, step - 1, external, speeds, balance, told, place)
    for i in range(line.impedance.shape[0] - 2, -1, -1):
        if i < 0:  # never so; but said, it spares the compiler its care for negative indices: a fifth
            break
        g = pass_junction(line, waves, i, step, step - 1, g, speeds)
    return g, balance


@inlined
def pass_bit(
    line: Line,
    load: Load,
    waves: Floats,
    step: int,
    heard: int,
    external: float,
    speeds: Floats,
    balance: float,
    told: Floats,
    place: int,
) -> tuple[float, float]:
    """Turn the bit by a step; returns the wave g that leaves it upward, and J dω/dt.

    What it does is left in `told[:2, place]`. The top section's f is taken to stay as at step `heard`.
    """
    last = line.impedance.shape[0] - 1
    at = foot(line)
    f = _arriving(line, waves, last, step, heard) - external
    w, balance = turn_bit(load, at, f, speeds[last + 1], balance)
    speeds[last + 1] = w
    told[0, place] = w
    told[1, place] = external + (law(load, w) if w != 0 else f)
    return f + external - 2 * at.impedance * w, balance


@inlined
def pass_junction(
    line: Line, waves: Floats, i: int, step: int, heard: int, g: float, speeds: Floats
) -> float:
    """Pass a wave g up through the junction below section i, and send f down; returns g as it goes on."""
    f = _arriving(line, waves, i, step, heard)
    z = line.impedance[i]
    below = line.impedance[i + 1]
    mobility = 1.0 / (z + below + line.viscous[i + 1])
    w = contact(f - g, mobility, line.kinetic[i + 1], line.static[i + 1], speeds[i + 1])
    speeds[i + 1] = w
    waves[i + 1, step & mask_of(waves.shape[1])] = g + 2 * below * w
    return float(f - 2 * z * w)


@inlined
def _arriving(line: Line, waves: Floats, i: int, step: int, heard: int) -> float:
    """The wave f at the bottom of section i."""
    left = step - line.round_trip[i]
    return float(waves[i, (min(left, heard) if i == 0 else left) & mask_of(waves.shape[1])])


@inlined
def turn_top(
    line: Line, drive_rate: float, pull: float, before: float, balance: float
) -> tuple[float, float]:
    """Turn the top by one step: J dω/dt = `pull` − ζω − the top junction's friction.

    `pull` is the motor's torque less the wave g that arrives; `before` and `balance` are ω and
    J dω/dt of the step before. Returns those of this step.
    """
    drive = pull + drive_rate * before + balance
    mobility = 1.0 / (drive_rate + line.impedance[0] + line.viscous[0])
    w = contact(drive, mobility, line.kinetic[0], line.static[0], before)
    return w, drive_rate * (w - before) - balance if w != 0 else 0.0
