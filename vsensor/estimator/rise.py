"""The waves that rise in all strings at once, to the same bits as `line.march` in each.

Each junction waits for the one below, and the processor with it. But the model string and its shadows do not
wait for one another: so they go side by side, junction by junction.
"""

import math

from vsensor.estimator.line import pass_bit
from vsensor.estimator.load import Load, contact
from vsensor.estimator.ring import mask_of
from vsensor.estimator.sections import Floats, Integers
from vsensor.estimator.state import BIT, Model, State, line_of
from vsensor.estimator.tune import LATER
from vsensor.jit import compiled, inlined


@compiled
def rise(model: Model, load: Load, state: State, step: int) -> None:
    """March all strings from the bit up for one step; at their tops g waits in the place of f."""
    line = model.line
    _turn_bits(model, load, state, step)
    _pass_junctions(
        model.impedances,
        model.round_trips,
        model.mobilities,
        line.kinetic,
        line.static,
        state.waves,
        state.junctions,
        step,
    )


@inlined
def _turn_bits(model: Model, load: Load, state: State, step: int) -> None:
    now = step & mask_of(state.waves.shape[2])
    for which in range(state.waves.shape[0]):
        waves, balances = state.waves[which], state.balances[which]
        waves[-1, now], balances[BIT] = pass_bit(
            line_of(model, which),
            _load_of(model, load, state, which),
            waves,
            step,
            step - 1,
            state.rock[which],
            state.junctions[which],
            balances[BIT],
            state.told[which],
            now,
        )


@inlined
def _load_of(model: Model, load: Load, state: State, which: int) -> Load:
    """What a string's bit meets. Those of two shadows break loose later and ring lower, or sooner and higher.

    How much holds a bit that rests, or slides slowly, is as uncertain as the rock is restless; and the pitch
    to which its string rings, where it has broken loose, as the lengths are: that of so stiff a string's end
    no surface channel tells. A bit that weighs more rings lower. What there is of a bit's inertia stays by
    half: without any it would not forget a correction of J dω/dt (trapezoid rule).
    """
    if which < LATER:
        return load
    rock = min(math.sqrt(state.rock_square[0]), load.static)
    if which == LATER:
        heavier = load.inertia_rate + model.ringing
        return Load(load.viscous, load.kinetic, load.static + rock, load.stribeck, heavier)
    lighter = max(load.inertia_rate - model.ringing, 0.5 * load.inertia_rate)
    return Load(load.viscous, load.kinetic, max(load.static - rock, load.kinetic), load.stribeck, lighter)


@inlined
def _pass_junctions(
    impedances: Floats,
    trips: Integers,
    mobilities: Floats,
    kinetic: Floats,
    static: Floats,
    waves: Floats,
    speeds: Floats,
    step: int,
) -> None:
    """Pass the junctions above the bits, as `line.pass_junction` does; g waits where f is to come."""
    mask = mask_of(waves.shape[2])
    now = step & mask
    for i in range(waves.shape[1] - 2, -1, -1):
        if i < 0:  # never so; but said, it spares the compiler its care for negative indices
            break
        slides, holds = kinetic[i + 1], static[i + 1]
        for which in range(waves.shape[0]):
            z, below = impedances[which, i], impedances[which, i + 1]
            f, g = waves[which, i, (step - trips[which, i]) & mask], waves[which, i + 1, now]
            w = contact(f - g, mobilities[which, i], slides, holds, speeds[which, i + 1])
            speeds[which, i + 1] = w
            waves[which, i + 1, now] = g + 2 * below * w
            waves[which, i, now] = f - 2 * z * w
