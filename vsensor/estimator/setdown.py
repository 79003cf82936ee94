"""A bit that is set down: between being told on bottom and meeting rock some time passes.

A clearance is left, and weight comes on over seconds. What the bit meets meanwhile is not what it will drill:
the law of before is kept, not in force and not learned, until the torque says that it holds again.
"""

from vsensor.estimator.learn import LATELY_S, SLIDING, Learned, weight_of
from vsensor.estimator.load import Load, law
from vsensor.jit import inlined

MET, FREE, AWAITED = range(3)
"""The bit meets rock; it is off bottom; it is told to be on bottom, and rock is awaited."""
SHARE = 0.3
"""Rock is met where so much of the law's torque is there,"""
PATIENCE_S = 30.0
"""or after so long: weaker rock, or less weight, than that of before."""


@inlined
def expect_rock(learned: Learned, off: bool, first: bool) -> None:
    """Hear that the bit is off bottom, or is not; at the `first` tick it may have drilled for long."""
    if off:
        learned.idle[0] = FREE
    elif first:
        learned.idle[0] = MET
    elif learned.idle[0] == FREE:
        learned.idle[0] = AWAITED


@inlined
def meets_rock(learned: Learned) -> bool:
    """Whether it does."""
    return bool(learned.idle[0] == MET)


@inlined
def look_for_rock(learned: Learned, speed: float, torque: float, waited: float, rate: float) -> None:
    """Take a confirmed pair of a bit that has been told to be on bottom for `waited` seconds.

    Once it is there, weight still comes on for a while: a law that was learned is kept for as long as the
    shorter memory, while a mere guess has nothing to lose.
    """
    if learned.idle[0] != AWAITED:
        return
    viscous, kinetic, static, stribeck = learned.law
    expected = law(Load(viscous, kinetic, static, stribeck, 0.0), max(abs(speed), SLIDING))
    if abs(torque) >= SHARE * expected or waited > PATIENCE_S:
        learned.idle[0] = MET
        learned.idle[1] = int(LATELY_S * rate) if weight_of(learned) > LATELY_S * rate else 0


@inlined
def wait_for_weight(learned: Learned) -> bool:
    """Let a tick of the time pass in which weight comes on; whether it is over."""
    learned.idle[1] = max(learned.idle[1] - 1, 0)
    return bool(learned.idle[1] == 0)
