"""The string at one moment: the kernels against their twins, closed forms, and what must be continuous."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests import naive
from tests.peel import descend
from tests.strings import COLLAR, PIPE, strings
from vsensor.config import Bit, Component
from vsensor.estimator import component
from vsensor.estimator.along import (
    INTERVALS,
    SPEED,
    TORQUE,
    Heard,
    Stations,
    alike_since,
    along,
    catch_up,
    keep_returned,
    late_correction,
    stations,
)
from vsensor.estimator.line import march
from vsensor.estimator.load import load_of
from vsensor.estimator.observe import correct_waves
from vsensor.estimator.ring import SPARE, length_of, mask_of
from vsensor.estimator.sections import Floats, Line, cut, junction_depths

STEP = 1e-2
SEEDS = st.integers(0, 2**32 - 1)
SMOOTH = strings(most=3).map(
    lambda string: tuple(
        part.model_copy(update={"coulomb_friction": 0.0, "static_friction": 0.0}) for part in string
    )
)


def unheard(line: Line) -> Heard:
    none, whole = np.zeros((1, len(line.impedance), 1)), np.zeros(1, np.int64)
    return Heard(none, line.round_trip, none, np.zeros(1), whole, 0, 1)


def laid_out(string: tuple[Component, ...], step: float = STEP) -> tuple[Line, Stations]:
    line = cut(string, step, 300)
    return line, stations(string, line, junction_depths(string, step, 300))


class Peeled:
    """A string peeled step by step, and what is told along it."""

    def __init__(self, line: Line, at: Stations) -> None:
        self.line, self.at = line, at
        self.travel = int(line.round_trip.sum()) // 2
        self.waves = np.zeros((len(line.impedance), length_of(2 * line.round_trip.sum())))
        self.returned = np.zeros_like(self.waves)
        self.speeds = np.zeros(len(line.impedance) + 1)
        self.steps = 0

    def peel(self, torque: float, speed: float) -> tuple[float, float]:
        self.steps += 1
        return descend(self.line, self.waves, self.returned, self.speeds, self.steps - 1, torque, speed)

    def told(self) -> Floats:
        told = np.empty((2, len(self.at.depth)))
        common = self.steps - 1 - self.travel
        along(self.line, self.waves, self.returned, unheard(self.line), self.at, common, told)
        return told


def truth(cells: naive.Cells, at: Stations) -> Floats:
    places = zip(at.section.tolist(), at.inside.tolist(), strict=True)
    return np.array([cells.at(section, cell) for section, cell in places]).T


@settings(max_examples=20)
@given(SMOOTH, SEEDS, st.floats(0, 2e3), st.integers(1, 150))
def test_the_string_at_one_moment_is_that_of_its_naive_twin(
    string: tuple[Component, ...], seed: int, drag: float, moment: int
) -> None:
    line, at = laid_out(string)
    cells, peeled = naive.Cells(line, drag), Peeled(line, at)
    speeds = 5 * np.random.default_rng(seed).standard_normal(moment + peeled.travel)
    expected = np.zeros((2, len(at.depth)))
    bottom = given_top = (0.0, 0.0)
    for k, speed in enumerate(speeds.tolist()):
        torque = cells.step(speed)
        bottom = peeled.peel(torque, speed)
        if k == moment - 1:
            expected, given_top = truth(cells, at), (speed, torque)
    told = peeled.told()
    np.testing.assert_allclose(told, expected, rtol=1e-7, atol=1e-6)
    assert told[:, 0] == pytest.approx(given_top, rel=1e-7, abs=1e-6)
    assert told[:, -1] == pytest.approx(bottom[::-1], rel=1e-7, abs=1e-6)


@settings(max_examples=20)
@given(SMOOTH, SEEDS, st.floats(0, 2e3))
def test_a_marched_string_leaves_the_waves_that_its_naive_twin_has(
    string: tuple[Component, ...], seed: int, drag: float
) -> None:
    line, at = laid_out(string)
    cells, peeled = naive.Cells(line, drag), Peeled(line, at)
    load, told = load_of(Bit(viscous_friction=drag), STEP), np.zeros((2, 1))
    moment = 40
    speeds = 5 * np.random.default_rng(seed).standard_normal(moment + peeled.travel)
    expected = np.zeros((2, len(at.depth)))
    for k, speed in enumerate(speeds.tolist()):
        waves = peeled.waves
        g, _ = march(line, load, waves, k, 0.0, peeled.speeds, 0.0, told, 0)
        keep_returned(line, waves, peeled.speeds, k, peeled.returned)
        peeled.speeds[0] = speed
        waves[0, k & mask_of(waves.shape[1])] = g + 2 * line.impedance[0] * speed
        cells.step(speed)
        peeled.steps += 1
        if k == moment - 1:
            expected = truth(cells, at)
    np.testing.assert_allclose(peeled.told(), expected, rtol=1e-7, atol=1e-6)


@settings(max_examples=20)
@given(strings(most=4), SEEDS)
def test_speed_and_torque_are_continuous_where_components_meet(
    string: tuple[Component, ...], seed: int
) -> None:
    """With Coulomb friction too, and whatever the surface measured."""
    line, at = laid_out(string)
    peeled = Peeled(line, at)
    for torque, speed in np.random.default_rng(seed).standard_normal((peeled.travel + 50, 2)).tolist():
        peeled.peel(5e3 * torque, 5 * speed)
    told = peeled.told()
    meets = np.flatnonzero(np.diff(at.component))
    assert len(meets) == len(string) - 1
    for told_of, above in zip(told, told[:, meets], strict=True):  # peeled noise grows on its way down
        np.testing.assert_allclose(above, told_of[meets + 1], atol=1e-10 * np.abs(told_of).max() + 1e-9)


@given(strings(), st.floats(1e-3, 2e-2))
def test_the_stations_cover_the_string_evenly(string: tuple[Component, ...], step: float) -> None:
    line, at = laid_out(string, step)
    length = sum(part.length for part in string)
    assert at.depth[0] == 0
    assert at.depth[-1] == pytest.approx(length)
    assert np.diff(at.depth).max() <= length / INTERVALS * (1 + 1e-9)
    assert np.diff(at.depth).min() >= 0
    assert len(at.depth) <= INTERVALS + 2 * len(string)
    assert (np.diff(at.down + at.inside) >= 0).all()
    assert (at.inside <= line.round_trip[at.section] // 2).all()
    for number, part in enumerate(string):
        depths = at.depth[at.component == number]
        assert depths[-1] - depths[0] == pytest.approx(part.length)


def test_a_part_that_was_lumped_with_its_neighbour_has_its_stations_in_the_common_section() -> None:
    sub = COLLAR.model_copy(update={"name": "sub", "length": 2.0})
    line, at = laid_out((PIPE, COLLAR, sub), 5e-3)
    last = len(line.impedance) - 1
    assert at.section[at.component > 0].tolist() == [last] * int((at.component > 0).sum())
    assert int((at.component == 2).sum()) == 2
    assert int(at.down[-1] + at.inside[-1]) == int(line.round_trip.sum()) // 2


@settings(max_examples=20)
@given(SEEDS, st.integers(1, 3), st.integers(1, 6), st.integers(0, 40), st.sampled_from([0.5, 0.05, 0.0]))
def test_what_is_heard_of_waves_may_be_added_late(
    seed: int, steps: int, lag: int, ticks: int, changes: float
) -> None:
    """As if every innovation had corrected them whole when it came."""
    random = np.random.default_rng(seed)
    of_waves, of_returned = random.standard_normal((2, 2, 3, lag * steps))
    innovations, levels, level = random.standard_normal(24), np.zeros(24, np.int64), 0
    inside, all_of_it = random.integers(0, 12, 3), np.full(3, lag * steps)
    at_once, late = np.zeros((2, 3, 64 + SPARE)), np.zeros((2, 3, 64 + SPARE))
    for tick in range(ticks):
        for step in range(tick * steps, (tick + 1) * steps):
            at_once[..., step & 63] = late[..., step & 63] = random.standard_normal((2, 3))
        said, level = random.standard_normal(1), level ^ int(random.random() < changes)
        innovations[tick % 24], levels[tick % 24] = said[0], level
        last = (tick + 1) * steps - 1
        correct_waves(of_waves[level], all_of_it, at_once[:1], last, said)
        correct_waves(of_returned[level], all_of_it, at_once[1:], last, said)
        correct_waves(of_waves[level], inside, late[:1], last, said)
    heard = Heard(of_waves, inside, of_returned, innovations, levels, ticks - 1, steps)
    since = alike_since(heard, ticks - 30)
    known = np.arange(max(0, (ticks - 24) * steps, ticks * steps - 64), ticks * steps)
    for section, (f, g) in enumerate(np.moveaxis(at_once, 1, 0)):
        for step in known.tolist():
            least = int(inside[section])
            said_of_f = late_correction(heard, since, of_waves[:, section], step, least)
            assert late[0, section, step & 63] + said_of_f == pytest.approx(f[step & 63], abs=1e-12)
            said_of_g = late_correction(heard, since, of_returned[:, section], step, 0)
            assert late[1, section, step & 63] + said_of_g == pytest.approx(g[step & 63], abs=1e-12)
    catch_up(heard, late[0], late[1])
    np.testing.assert_allclose(late[..., known & 63], at_once[..., known & 63], atol=1e-12)


def test_both_sides_of_a_joint_inside_a_section_are_one_place() -> None:
    """Two pipes so short that they share a section of one step, and meet just where that is rounded."""
    pipe = PIPE.model_copy(update={"length": 3.0})
    _, at = laid_out((pipe, pipe))
    (meet,) = np.flatnonzero(np.diff(at.component))
    assert at.section[meet] == at.section[meet + 1]
    assert at.inside[meet] == at.inside[meet + 1]


def test_a_standing_wave() -> None:
    """A pipe free at its bottom: ω = A cos k(L−d) cos Ωt, T = −ζA sin k(L−d) sin Ωt (wave equation)."""
    pipe = PIPE.model_copy(update={"viscous_friction": 0.0})
    steps = 80
    step = component.delay(pipe) / steps
    line, at = laid_out((pipe,), step)
    peeled = Peeled(line, at)
    omega, z, most = 2 * math.pi * 0.7, component.impedance(pipe), 6.0
    up = omega / component.wave_speed(pipe) * pipe.length
    for k in range(4 * steps):
        swing = omega * k * step
        peeled.peel(-z * most * math.sin(up) * math.sin(swing), most * math.cos(up) * math.cos(swing))
    below = omega * step * (steps - at.inside)  # each station on the grid
    swing = omega * step * (peeled.steps - 1 - peeled.travel)
    told = peeled.told()
    np.testing.assert_allclose(told[SPEED], most * np.cos(below) * math.cos(swing), atol=1e-9)
    np.testing.assert_allclose(told[TORQUE], -z * most * np.sin(below) * math.sin(swing), atol=1e-6)
