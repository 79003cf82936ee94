"""Dry friction on the lumped string: events where they belong, no chatter, and section III's two figures."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import brentq

from vsensor.paper import lumped, stick_slip
from vsensor.paper.chain import Chain, Motion, simulate, stribeck
from vsensor.paper.shaft import SHAFT

STRING = lumped.of_shaft(SHAFT)
Floats = NDArray[np.float64]


def late(motion: Motion) -> Floats:
    """The bit's speed once the start is forgotten."""
    speeds: Floats = motion.speeds[1][motion.time > motion.time[-1] / 2]
    return speeds


def test_7000_newton_metres_stick_and_slip_between_rest_and_the_papers_amplitude() -> None:
    motion = stick_slip.drill(STRING, 7000.0, 120.0)
    bit = late(motion)
    assert bit.min() == 0
    assert bit.max() == pytest.approx(0.8, abs=0.002)
    assert 0.25 < np.mean(bit == 0) < 0.3
    # Each cycle is held, free, caught, and nothing in between: no chatter.
    assert [event.regime for event in motion.events] == (["held", "free", "caught"] * 99)[
        : len(motion.events)
    ]
    assert np.diff([event.time for event in motion.events]).min() > 0.5


def test_9000_newton_metres_end_it() -> None:
    motion = stick_slip.drill(STRING, 9000.0, 120.0)
    assert [event.regime for event in motion.events] == ["held", "free", "caught"]
    assert motion.speeds[1][-1] == pytest.approx((9000 - stick_slip.CAUGHT) / 400, rel=1e-6)


@pytest.mark.parametrize(
    ("sticktion", "least_rest", "most_rest"),
    [
        (6000.0, 0, 0),
        (6900.0, 0, 0),
        (7050.0, 0.1, 0.15),
        (7150.0, 0.4, 0.45),
        (7200.0, 1, 1),
        (7500.0, 1, 1),
    ],
)
def test_the_rest_hangs_on_the_sticktion(sticktion: float, least_rest: float, most_rest: float) -> None:
    """Below the motor's torque the bit touches zero, somewhat above it rests, far above it stays."""
    bit = late(stick_slip.drill(STRING, 7000.0, 120.0, sticktion))
    assert least_rest <= np.mean(bit == 0) <= most_rest
    assert bit.min() < 0.001
    assert bit.max() == pytest.approx(0.8 if most_rest < 1 else 0, abs=0.002)


def test_sticktion_must_hold_more_than_the_bit_turns_against() -> None:
    with pytest.raises(ValueError, match="at least FREE, 6000"):
        stick_slip.relay(5900.0)


def test_events_stand_where_the_exact_solution_has_them() -> None:
    """Between events the string is linear: a matrix exponential and Brent's method find the next event."""
    motion = stick_slip.drill(STRING, 7000.0, 40.0)
    exact = exact_events(7000.0, len(motion.events))
    assert [event.time for event in motion.events] == pytest.approx(exact, abs=1e-6)


def exact_events(torque: float, count: int) -> list[float]:
    a, b, _ = lumped.state_space(STRING)
    held = a.copy()
    held[2] = 0.0
    friction = {"free": stick_slip.FREE, "caught": stick_slip.CAUGHT}
    state, now, regime, times = np.zeros(3), 0.0, "held", [0.0]

    def after(x: Floats, dt: float) -> Floats:
        """x and a constant input, carried on by one exponential."""
        drive = b[:, 0] * torque
        if regime != "held":
            drive = drive - np.array([0.0, 0.0, friction[regime] / STRING.J_b])
        system = np.block([[held if regime == "held" else a, drive[:, None]], [np.zeros((1, 4))]])
        moved: Floats = (expm(system * dt) @ np.append(x, 1.0))[:3]
        return moved

    def margin(x: Floats) -> float:
        if regime == "held":
            return float(STRING.k * x[0] + STRING.c * x[1] - stick_slip.STICKTION)
        return float(x[2] - stick_slip.CATCH_SPEED) if regime == "free" else float(-x[2])

    while len(times) < count:
        span = 0.02
        while margin(after(state, span)) < 0:
            span += 0.02
        # Just after an event its own margin is zero; the next one is later.
        found = brentq(lambda dt, x=state: margin(after(x, dt)), max(1e-6, span - 0.02), span, xtol=1e-13)
        state, now = after(state, found), now + found
        times.append(now)
        regime = {"held": "free", "free": "caught", "caught": "held"}[regime]
        if regime == "held":
            state[2] = 0.0
    return times


def test_no_fall_of_friction_makes_this_string_swing() -> None:
    """Past a fall of C_r + C_b the mean speed runs away, yet the pair of swinging roots never grows."""
    for slope in np.concatenate([np.linspace(1, 5001, 501), np.logspace(4, 7, 50)]):
        roots = stick_slip.growth(STRING, float(slope))
        swinging = roots[np.abs(roots.imag) > 1e-6]
        steady = roots[np.abs(roots.imag) <= 1e-6]
        assert len(swinging) == 2
        assert swinging.real.max() < 0
        assert (steady.real.max() > 0) == (slope > 400)


def test_power_in_is_power_stored_and_lost() -> None:
    chain = Chain(
        inertia=np.array([900.0, 400.0, 300.0]),
        stiffness=np.array([600.0, 900.0]),
        damping=np.array([20.0, 10.0]),
        drag=np.array([300.0, 10.0, 5.0]),
    )
    law = stribeck(kinetic=4e3, static=6e3, speed=1.0)
    motion = simulate(chain, law, 5e3, 60.0, step=1e-3)
    speeds, time = motion.speeds, motion.time
    slips = speeds[:-1] - speeds[1:]
    twists = np.concatenate(
        [np.zeros((2, 1)), np.cumsum((slips[:, 1:] + slips[:, :-1]) / 2 * np.diff(time), axis=1)], axis=1
    )
    stored = (chain.inertia @ speeds**2 + chain.stiffness @ twists**2) / 2
    bit = speeds[-1]
    rubbing = bit * (4e3 + 2e3 * np.exp(-bit))
    power = 5e3 * speeds[0] - chain.drag @ speeds**2 - chain.damping @ slips**2 - rubbing
    balance = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])
    assert len(motion.times("held")) > 3
    np.testing.assert_allclose(stored, balance, atol=1e-4 * stored.max())


def test_a_held_bit_stands_still_and_a_free_one_turns_forward() -> None:
    motion = stick_slip.drill(STRING, 7000.0, 60.0)
    starts = [event.time for event in motion.events]
    for event, end in zip(motion.events, [*starts[1:], 60.0], strict=True):
        inside = (motion.time > event.time + 0.02) & (motion.time < end - 0.02)
        bit = motion.speeds[1][inside]
        assert np.all(bit == 0) if event.regime == "held" else np.all(bit > 0)
