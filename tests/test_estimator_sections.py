"""The string on its grid."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.strings import COLLAR, PIPE, strings
from vsensor.config import Component
from vsensor.estimator import component
from vsensor.estimator.sections import FINEST, cut, longest_round_trips, steps_per_tick, stretched

STEPS = st.floats(1e-4, 1e-2)
LONG = PIPE.model_copy(update={"length": 3000.0})


@given(strings(), STEPS, st.floats(50, 1000))
def test_depths_are_rounded_not_lengths_so_the_error_never_adds_up(
    string: tuple[Component, ...], step: float, section_length: float
) -> None:
    delays = [component.delay(part) for part in string]
    assume(min(delays) > step)
    line = cut(string, step, section_length)
    assert line.round_trip.sum() / 2 * step == pytest.approx(sum(delays), abs=step / 2 * (1 + 1e-9))


@given(strings(), STEPS, st.floats(0, 0.2), st.floats(-1, 1))
def test_no_round_trip_of_a_stretched_line_is_longer_than_its_bound(
    string: tuple[Component, ...], step: float, most: float, part: float
) -> None:
    line = cut(string, step, 300)
    assert (stretched(line, part * most).round_trip <= longest_round_trips(line, most)).all()


@given(strings(), STEPS)
def test_every_section_lasts_at_least_one_step(string: tuple[Component, ...], step: float) -> None:
    line = cut(string, step, 300)
    assert (line.round_trip >= 2).all()
    assert (line.round_trip % 2 == 0).all()


@given(strings(), STEPS, st.floats(50, 1000))
def test_lumping_keeps_all_friction(
    string: tuple[Component, ...], step: float, section_length: float
) -> None:
    line = cut(string, step, section_length)
    for lumped, per_metre in (
        (line.viscous, "viscous_friction"),
        (line.kinetic, "coulomb_friction"),
        (line.static, "static_friction"),
    ):
        assert len(lumped) == len(line.impedance) + 1
        assert lumped.sum() == pytest.approx(sum(getattr(p, per_metre) * p.length for p in string))


def test_a_part_shorter_than_a_step_leaves_inertia_and_compliance_as_they_were() -> None:
    sub = Component(length=2, outer_diameter=0.2, inner_diameter=0.07)
    step = 2e-3
    line = cut((COLLAR, sub), step, 300)
    (z,) = line.impedance
    delay = component.delay(COLLAR) + component.delay(sub)
    inertia = component.inertia(COLLAR) + component.inertia(sub)
    compliance = 1 / component.stiffness(COLLAR) + 1 / component.stiffness(sub)
    assert z == pytest.approx(np.sqrt(inertia / compliance), rel=1e-12)
    assert line.round_trip[0] / 2 * step == pytest.approx(np.sqrt(inertia * compliance), abs=step / 2)
    assert line.round_trip[0] / 2 * step == pytest.approx(delay, rel=0.05)


@given(st.integers(1, 400), STEPS, st.floats(0.5, 300))
def test_a_string_told_in_pieces_shorter_than_a_step_does_not_become_one_section(
    pieces: int, step: float, section_length: float
) -> None:
    piece = PIPE.model_copy(update={"length": PIPE.length / pieces})
    line = cut((piece,) * pieces, step, section_length)
    assert line.impedance == pytest.approx(component.impedance(PIPE))
    assert line.depth[-1] * step == pytest.approx(component.delay(PIPE))
    longest = min(component.delay(piece), section_length / component.wave_speed(PIPE))
    assert np.diff(line.depth).max() * step <= max(2 * step, longest) + step


def test_what_is_left_goes_to_the_shorter_neighbour() -> None:
    sub = Component(length=2, outer_diameter=0.2, inner_diameter=0.07)
    for string in ((PIPE, sub, COLLAR), (COLLAR, sub, PIPE)):
        impedances = cut(string, 2e-3, 3000).impedance
        expected = [component.impedance(part) for part in string if part is not sub]
        changed = [
            z for z, was in zip(impedances, expected, strict=True) if z != pytest.approx(was, rel=1e-9)
        ]
        assert changed == [pytest.approx(component.impedance(COLLAR), rel=0.1)]


def test_only_what_rubs_is_cut() -> None:
    assert len(cut((PIPE,), 1e-3, 300).impedance) == 5
    assert len(cut((COLLAR,), 1e-3, 50).impedance) == 1


@pytest.mark.parametrize(("rate", "expected"), [(100, 3), (1000, 1), (20, 13)])
def test_the_step_is_fine_enough_for_the_string(rate: float, expected: int) -> None:
    assert steps_per_tick((LONG,), 1 / rate) == expected


@given(strings(), st.sampled_from([20.0, 100.0, 1000.0]))
def test_half_a_step_is_a_four_hundredth_of_the_string_or_an_eighth_of_a_millisecond(
    string: tuple[Component, ...], rate: float
) -> None:
    steps = steps_per_tick(string, 1 / rate)
    travel = sum(component.delay(part) for part in string)
    assert steps == FINEST or 0.5 / rate / steps <= max(travel / 400, 0.125e-3) * (1 + 1e-9)


def test_the_step_follows_the_shortest_component_down_to_a_limit() -> None:
    short = COLLAR.model_copy(update={"length": 9.75})
    assert steps_per_tick((LONG, short), 0.01) == 4
    shorter = COLLAR.model_copy(update={"length": 0.3})
    assert steps_per_tick((LONG, shorter), 0.01) == FINEST


@given(st.floats(120, 1500), st.floats(30, 200), st.floats(30, 200))
def test_a_short_strings_components_end_where_the_grid_has_a_step(
    pipe: float, heavy: float, collars: float
) -> None:
    """Half as many steps again are taken where they fit three times better, and else none more."""
    string = tuple(
        part.model_copy(update={"length": length})
        for part, length in ((PIPE, pipe), (PIPE, heavy), (COLLAR, collars))
    )
    delays = np.array([component.delay(part) for part in string])

    def rounding(steps: int) -> float:
        on_grid = delays[1:] * steps / 0.01
        return float(np.max(np.abs(np.round(on_grid) / on_grid - 1)))

    chosen = steps_per_tick(string, 0.01)
    least = math.ceil(0.01 / max(delays.sum() / 200, 0.25e-3, 0.01 / FINEST) * (1 - 1e-12))
    best = min(map(rounding, range(least, min(FINEST, int(1.5 * least)) + 1)))
    if best < 0.33 * rounding(least):
        assert rounding(chosen) == pytest.approx(best)
    if best > 0.34 * rounding(least):
        assert chosen == least


def test_collars_of_a_short_string_are_as_long_on_the_grid_as_they_are() -> None:
    """Of 157, 47 and 47 ms, in eight steps a tick the collars would be 2 % too short."""
    string = tuple(LONG.model_copy(update={"length": length}) for length in (500.0, 150.0, 150.0))
    line = cut(string, 0.01 / steps_per_tick(string, 0.01), 1000)
    on_grid = line.round_trip[1:] / 2 * 0.01 / steps_per_tick(string, 0.01)
    np.testing.assert_allclose(on_grid, component.delay(string[1]), rtol=0.003)


@given(st.floats(300, 500), st.floats(0, 30))
def test_pipe_added_on_top_leaves_the_grid_as_it_was(length: float, more: float) -> None:
    """But where so much is added that fewer steps would do."""
    string = tuple(part.model_copy(update={"length": length}) for part in (PIPE, COLLAR))
    longer = (string[0].model_copy(update={"length": length + more}), string[1])
    travels = [sum(component.delay(part) for part in each) for each in (string, longer)]
    assume(math.ceil(0.01 * 200 / travels[0]) == math.ceil(0.01 * 200 / travels[1]))
    assert steps_per_tick(string, 0.01) == steps_per_tick(longer, 0.01)


def test_the_papers_string() -> None:
    """Section 2 of the derivation: the numbers of the paper's pipe, each computed by two methods."""
    pipe = Component(
        length=4000, outer_diameter=0.1682, inner_diameter=0.149884, shear_modulus=79.6e9, density=8009
    )
    assert component.polar_moment(pipe) == pytest.approx(2.903111e-5, rel=1e-6)
    assert component.wave_speed(pipe) == pytest.approx(3152.59, rel=1e-6)
    assert component.delay(pipe) == pytest.approx(1.268798, rel=1e-6)
    assert component.impedance(pipe) == pytest.approx(733.009, rel=1e-6)
    assert component.stiffness(pipe) == pytest.approx(577.719, rel=1e-6)
    assert component.inertia(pipe) == pytest.approx(930.041, rel=1e-6)


def test_depths_that_fall_between_two_steps_leave_no_section_without_one() -> None:
    """Halves rounded to even would give 1.5 and 2.5 steps the same depth."""
    pipe = Component(length=22.5, outer_diameter=0.127, inner_diameter=0.1, shear_modulus=72e9, density=8000)
    string = tuple(pipe.model_copy(update={"length": length}) for length in (22.5, 15.0, 1500.0))
    assert (cut(string, 5e-3, 300).round_trip >= 2).all()
