"""The waves in the string: up from the bit by a load law, down from the top by what turns it.

Everything runs in slanted time: at internal step k the junction at depth d is seen at the time
k − θ(d), one travel time late. A wave that leaves a section's top at step k then left its bottom
at step k too, so that torque upward costs no delay, and only the wave downward is held: its
round trip 2θ later it stands at the bottom, in the same slanted time. One array holds it all,
`waves[section, step & mask]`, the wave f = T + ζω at the top of each section. (Paper eq. 17, as
mended in docs/theory; the method of characteristics.)
"""

from vsensor.estimator.load import Load, contact, foot, law, turn_bit
from vsensor.estimator.sections import Floats, Line
from vsensor.jit import compiled

EVERY_JUNCTION = 1 << 60
"""A reach for the march that spares no junction."""

FADE_SPEED = 1.0
"""Below this speed (rad/s) Coulomb friction fades to zero where it is told of a speed that was measured: a
junction at rest may bear any torque up to the static one, and the sign of its noise would throw the full
friction from side to side."""


@compiled
def rubbing(line: Line, junction: int, speed: float) -> float:
    """Friction of a junction that turns at a measured speed, N·m."""
    share = min(1.0, max(-1.0, speed / FADE_SPEED))
    return float(line.viscous[junction] * speed + line.kinetic[junction] * share)


@compiled
def march(
    line: Line,
    load: Load,
    waves: Floats,
    known: int,
    steps: int,
    heard: int,
    reach: int,
    external: float,
    fade: float,
    speeds: Floats,
    balance: float,
    told: Floats,
) -> tuple[float, float]:
    """March the string from the bit up by a load law, for `steps` steps after step `known`.

    Enters f of those steps into all sections but the top one, whose f has been heard up to step
    `heard` and is taken to stay from then on. `speeds` (M + 1,) and `balance`, J dω/dt of the bit,
    are the state at `known`; the first is replaced. Each step leaves bit speed and torque in `told`
    (2, ≥ steps). Only junctions whose wave reaches the bit within `reach` steps matter; none is spared
    where that is large. `external` is a further torque on the bit, of which a share `fade` is left at
    each following step. Returns the wave g that leaves the top at the last step, and the new balance.
    """
    mask = waves.shape[1] - 1
    last = line.impedance.shape[0] - 1
    at = foot(line)
    g = 0.0
    highest = 0
    matters = reach - line.round_trip[1:].sum() if reach < EVERY_JUNCTION else EVERY_JUNCTION
    for ahead in range(1, steps + 1):
        while ahead > matters and highest < last:
            highest += 1
            matters += line.round_trip[highest]
        step = known + ahead
        left = step - line.round_trip[last]
        f = waves[last, (min(left, heard) if last == 0 else left) & mask] - external
        w, balance = turn_bit(load, at, f, speeds[last + 1], balance)
        speeds[last + 1] = w
        told[0, ahead - 1] = w
        told[1, ahead - 1] = external + (law(load, w) if w != 0 else f)
        g = f + external - 2 * at.impedance * w
        external *= fade
        for i in range(last - 1, highest - 1, -1):
            if i < 0:  # never so; but said, it spares the compiler its care for negative indices: a fifth
                break
            left = step - line.round_trip[i]
            f = waves[i, (min(left, heard) if i == 0 else left) & mask]
            z = line.impedance[i]
            below = line.impedance[i + 1]
            w = contact(
                f - g, z + below + line.viscous[i + 1], line.kinetic[i + 1], line.static[i + 1], speeds[i + 1]
            )
            speeds[i + 1] = w
            waves[i + 1, step & mask] = g + 2 * below * w
            g = f - 2 * z * w
    return g, balance


@compiled
def turn_top(
    line: Line, drive_rate: float, pull: float, before: float, balance: float
) -> tuple[float, float]:
    """Turn the top by one step: J dω/dt = `pull` − ζω − the top junction's friction.

    `pull` is the motor's torque less the wave g that arrives; `before` and `balance` are ω and
    J dω/dt of the step before. Returns those of this step.
    """
    drive = pull + drive_rate * before + balance
    resistance = drive_rate + line.impedance[0] + line.viscous[0]
    w = contact(drive, resistance, line.kinetic[0], line.static[0], before)
    return w, drive_rate * (w - before) - balance if w != 0 else 0.0
