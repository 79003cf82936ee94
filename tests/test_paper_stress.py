"""Shear stress at the end and along the shaft."""

import math

import numpy as np
import pytest

from tests.peel import peeled
from vsensor.estimator import component
from vsensor.estimator.sections import cut
from vsensor.paper import comparison, fine
from vsensor.paper.shaft import BIT, SHAFT, TORQUE, shear_stress
from vsensor.paper.stress import torque_along, wave_between, wave_held

DEPTH = np.array([0.0, 1000.0, 2500.0, 4000.0])


def test_stress_is_torque_times_radius_over_moment() -> None:
    moment = math.pi / 2 * (0.0841**4 - 0.074942**4)
    assert shear_stress(SHAFT, 7000.0) == pytest.approx(7000 * 0.0841 / moment)
    assert shear_stress(SHAFT, 7000.0) == pytest.approx(20.28e6, rel=1e-3)


def test_along_the_shaft_the_fine_steps_are_the_closed_form() -> None:
    of = comparison.models(4000.0, until=30.0)
    time = np.linspace(0.003, 20, 777)
    found = torque_along(wave_between(of.fine, SHAFT, TORQUE), SHAFT, TORQUE, DEPTH, time)
    expected = np.array([of.truth.torque_at(depth, time) for depth in DEPTH])
    # A front is somewhere within a step; nothing else is far.
    far = np.abs(found - expected) > 0.02 * TORQUE
    assert far.mean() < 0.005
    np.testing.assert_allclose(found[~far], expected[~far], atol=0.02 * TORQUE)
    assert np.sqrt(np.mean((found[~far] - expected[~far]) ** 2)) < 1e-3 * TORQUE
    np.testing.assert_allclose(found[0], TORQUE)


def test_the_papers_waves_end_in_its_own_end_torque() -> None:
    of = comparison.models(4000.0)
    held = wave_held(of.printed, SHAFT, TORQUE)
    time = of.printed.end_torque.time[:-2] + 0.01
    ends = torque_along(held, SHAFT, TORQUE, np.array([SHAFT.length]), time)[0]
    assert ends == pytest.approx(of.printed.end_torque.value[:-2], rel=1e-9)


def test_peeling_finds_the_same_torque_at_depth() -> None:
    """What torque and speed at the top tell of a depth is what the paper room draws."""
    steps = 400
    answer = fine.stepped(SHAFT, BIT, TORQUE, 12.0, steps)
    h = component.delay(SHAFT) / steps
    part = SHAFT.model_copy(update={"length": SHAFT.length / 4})
    line = cut((part,), h, 1e4)
    found = peeled(line, np.full(len(answer.top.value), TORQUE), answer.top.value)[:, 0]
    drawn = torque_along(
        wave_between(answer, SHAFT, TORQUE),
        SHAFT,
        TORQUE,
        np.array([part.length]),
        answer.top.time - component.delay(part),
    )[0]
    late = answer.top.time > 2 * component.delay(part)
    np.testing.assert_allclose(found[late], drawn[late], rtol=1e-6, atol=1e-3)


def test_a_heavy_load_doubles_the_first_wave() -> None:
    of = comparison.models(4000.0)
    trace = of.fine.end_torque
    first = trace.value[trace.time < 2 * component.delay(SHAFT)].max()
    assert first == pytest.approx(2 * TORQUE, rel=1e-3)
    assert of.printed.end_torque.value.max() < 1.3 * TORQUE
    assert of.lumped.end_torque.value.max() < TORQUE
