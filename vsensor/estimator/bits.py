"""The bits of many marches at once, a lane each: each turns as `load.turn_bit` has it, to the last digit."""

import math

from vsensor.estimator.exponential import exponential
from vsensor.estimator.load import CLOSE, MOST, Load, foot, law
from vsensor.estimator.sections import Floats, Line
from vsensor.jit import inlined

LANES = 64
"""So many ticks march at once: vectors enough to follow each other without a pause."""

# Where the bits' numbers begin in one array, a lane each: of its parts the compiler sees that they lie apart.
PARTS = 13
SPEED, BALANCE, EXTERNAL, DRIVE, FOUND, UNSETTLED = range(0, 6 * LANES, LANES)
VISCOUS, KINETIC, STATIC, STRIBECK, RATE, RESISTANCE, MOBILITY = range(6 * LANES, PARTS * LANES, LANES)


@inlined
def set_out_bit(line: Line, load: Load, inertia_rate: float, bits: Floats, lane: int) -> None:
    """Keep what a bit meets on its march, and what would be worked out anew at each step of it."""
    bits[VISCOUS + lane], bits[KINETIC + lane] = load.viscous, load.kinetic
    bits[STATIC + lane], bits[STRIBECK + lane] = load.static, load.stribeck
    at = foot(line)
    resistance = inertia_rate + at.impedance + at.viscous + load.viscous
    bits[RESISTANCE + lane], bits[MOBILITY + lane] = resistance, 1.0 / resistance
    bits[RATE + lane] = 1.0 / load.stribeck


@inlined
def turn_bits(line: Line, inertia_rate: float, arriving: Floats, bits: Floats) -> None:
    """Find how fast each bit turns, as `load.turn_bit` does: one step of Newton's for all, mostly enough."""
    at = foot(line)
    unsettled = 0
    for lane in range(LANES):
        before, kinetic, static = bits[SPEED + lane], bits[KINETIC + lane], bits[STATIC + lane]
        drive = arriving[lane] - bits[EXTERNAL + lane] + inertia_rate * before + bits[BALANCE + lane]
        left = abs(drive) - kinetic - at.kinetic
        resistance = bits[RESISTANCE + lane]
        x = left * bits[MOBILITY + lane]
        slides = (x > 0) & ((before != 0) | (abs(drive) > static + at.static))
        falls = slides & (static != kinetic)
        nearer, settled = _nearer(x, left, resistance, static - kinetic, bits[RATE + lane])
        bits[DRIVE + lane] = drive
        bits[FOUND + lane] = (nearer if falls else x) if slides else 0.0
        bits[UNSETTLED + lane] = 1.0 if falls & (not settled) else 0.0
        unsettled += 1 if falls & (not settled) else 0
    for _ in range(MOST - 1):
        if unsettled == 0:
            break
        unsettled = _approach(line, bits)


@inlined
def _approach(line: Line, bits: Floats) -> int:
    """One more of Newton's steps for those that need it; returns how many still do."""
    at = foot(line)
    unsettled = 0
    for lane in range(LANES):
        goes_on = bits[UNSETTLED + lane] != 0
        kinetic, x = bits[KINETIC + lane], bits[FOUND + lane]
        left = abs(bits[DRIVE + lane]) - kinetic - at.kinetic
        fall = bits[STATIC + lane] - kinetic
        nearer, settled = _nearer(x, left, bits[RESISTANCE + lane], fall, bits[RATE + lane])
        bits[FOUND + lane] = nearer if goes_on else x
        bits[UNSETTLED + lane] = 1.0 if goes_on & (not settled) else 0.0
        unsettled += 1 if goes_on & (not settled) else 0
    return unsettled


@inlined
def _nearer(x: float, drive: float, resistance: float, fall: float, rate: float) -> tuple[float, bool]:
    """One of Newton's steps as in `load._sliding`, and whether it was the last; 0 where the bit is held."""
    gone = fall * exponential(-x * rate)
    slope = gone * rate
    steep = resistance - slope
    change = (resistance * x + gone - drive) / steep
    x -= change
    held = (steep <= 0) | (x <= 0)
    near = slope * rate * change * change <= CLOSE * x * steep
    return 0.0 if held else x, held | near


@inlined
def tell_torques(arriving: Floats, bits: Floats, told: Floats) -> None:
    """Tell what the bits are about to meet."""
    for lane in range(LANES):
        load = Load(
            bits[VISCOUS + lane], bits[KINETIC + lane], bits[STATIC + lane], bits[STRIBECK + lane], 0.0
        )
        external = bits[EXTERNAL + lane]
        w = math.copysign(bits[FOUND + lane], bits[DRIVE + lane])
        told[lane] = external + (law(load, w) if w != 0 else arriving[lane] - external)


@inlined
def move_bits(
    line: Line, inertia_rate: float, fade: float, arriving: Floats, bits: Floats, told: Floats
) -> None:
    """Let the bits turn as was found, tell of it, and leave g in the place of the waves that arrived."""
    impedance = line.impedance[-1]
    for lane in range(LANES):
        external, found = bits[EXTERNAL + lane], bits[FOUND + lane]
        w = math.copysign(found, bits[DRIVE + lane]) if found != 0 else 0.0
        balance = inertia_rate * (w - bits[SPEED + lane]) - bits[BALANCE + lane]
        bits[BALANCE + lane] = balance if found != 0 else 0.0
        bits[SPEED + lane] = w
        bits[EXTERNAL + lane] = external * fade
        told[lane] = w
        arriving[lane] = arriving[lane] - external + external - 2 * impedance * w
