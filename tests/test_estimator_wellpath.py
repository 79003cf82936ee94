"""The wall's friction from the well's path: closed forms, a naive twin, and what must not matter."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.naive_well import wall_torque
from vsensor.config import Component
from vsensor.config.well import Station, Wellbore, from_surface
from vsensor.estimator import component, wall
from vsensor.estimator.component import GRAVITY, buoyed_weight
from vsensor.estimator.sections import cut
from vsensor.estimator.wall import contact, wall_friction
from vsensor.estimator.wellpath import direction, vertical_depth, well_path

PIPE = Component(length=900, outer_diameter=0.127, inner_diameter=0.1086, tool_joint_diameter=0.168)
COLLAR = Component(length=150, outer_diameter=0.1652, inner_diameter=0.0714)
MUD = Wellbore(mud_density=1200, friction_factor=0.25, static_friction_factor=0.3)

Survey = tuple[Station, ...]


def survey(*stations: tuple[float, float, float]) -> Survey:
    """Stations of measured depth (m), inclination and azimuth (deg)."""
    return from_surface(
        tuple(
            Station(measured_depth=depth, inclination=math.radians(angle), azimuth=math.radians(azimuth))
            for depth, angle, azimuth in stations
        )
    )


def weightless() -> Component:
    """Pipe of the mud's own density."""
    return PIPE.model_copy(update={"density": MUD.mud_density})


@st.composite
def surveys(draw: st.DrawFn) -> Survey:
    """Wells as they are drilled, some of them up a little at the end; the string may end above or below."""
    depth, angle, azimuth = 0.0, draw(st.floats(0, 60)), draw(st.floats(-180, 180))
    stations = [(depth, angle, azimuth)]
    for _ in range(draw(st.integers(1, 6))):
        depth += draw(st.floats(50, 500))
        angle = min(100.0, abs(angle + draw(st.floats(-20, 30))))
        azimuth = (azimuth + draw(st.floats(-40, 40))) % 360
        stations.append((depth, angle, azimuth))
    return survey(*stations)


WELLBORES = st.builds(
    lambda mud, factor, more, weight: Wellbore(
        mud_density=mud,
        friction_factor=factor,
        static_friction_factor=factor * more,
        weight_on_bit=weight,
    ),
    mud=st.floats(1, 2500),
    factor=st.floats(0.05, 0.5),
    more=st.floats(1, 2),
    weight=st.floats(0, 3e5),
)
STRINGS = st.lists(
    st.builds(
        lambda length, outer, inner, joint: Component(
            length=length,
            outer_diameter=outer,
            inner_diameter=outer * inner,
            tool_joint_diameter=outer * joint,
        ),
        length=st.floats(5, 600),
        outer=st.floats(0.08, 0.25),
        inner=st.floats(0.2, 0.9),
        joint=st.floats(1, 1.4),
    ),
    min_size=1,
    max_size=4,
).map(tuple)


def test_minimum_curvature_as_the_textbooks_work_it() -> None:
    """The example that drillers' handbooks print: 12.95° of dogleg, 94.01 ft deeper for 100 ft of well."""
    foot = 0.3048
    path = well_path(survey((0, 15, 20), (100 * foot, 25, 45)))
    assert math.degrees(path.curvature[0] * 100 * foot) == pytest.approx(12.95, abs=0.005)
    assert path.place[1] / foot == pytest.approx([27.22, 19.45, 94.01], abs=0.005)


def test_a_quarter_circle_ends_where_it_must() -> None:
    radius = 300.0
    end = radius * math.pi / 2
    path = well_path(survey((0, 0, 70), (end, 90, 70)))
    depth = np.array([0, end / 3, end, end + 500])
    assert vertical_depth(path, depth) == pytest.approx([0, radius / 2, radius, radius])
    tangent, bend = direction(path, depth)
    assert np.degrees(np.arccos(tangent[:, 2])) == pytest.approx([0, 30, 90, 90])
    assert np.linalg.norm(bend, axis=1) == pytest.approx([1 / radius, 1 / radius, 0, 0])
    assert (tangent * bend).sum(axis=1) == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("angle", [12.0, 60.0, 90.0, 120.0])
def test_a_straight_inclined_string_presses_with_its_weight_across(angle: float) -> None:
    """N = w sin I."""
    friction = wall_friction((PIPE,), survey((0, angle, 40), (500, angle, 40)), MUD)
    pressed = buoyed_weight(PIPE, MUD.mud_density) * math.sin(math.radians(angle)) * PIPE.length
    assert friction.kinetic == pytest.approx([0.25 * pressed * 0.084], rel=1e-12)
    assert friction.static == pytest.approx([0.3 * pressed * 0.084], rel=1e-12)


def test_a_weightless_string_bent_round_under_tension_is_a_capstan() -> None:
    """N = F/R, so the torque is μ F r times the angle: here a quarter turn, with collars hung below it."""
    bent = survey((0, 90, 40), (900, 0, 40), (1200, 0, 40))
    string = (weightless(), COLLAR)
    force = buoyed_weight(COLLAR, 1200) * COLLAR.length
    lies = contact(string, well_path(bent), MUD)
    assert lies.tension[lies.part == 0] == pytest.approx(force, rel=1e-12)
    friction = wall_friction(string, bent, MUD).kinetic
    assert friction == pytest.approx([0.25 * force * 0.084 * math.pi / 2, 0], rel=1e-12)


def test_compression_presses_like_tension() -> None:
    """The same turned sideways by 60°, pushed from below by the weight on bit."""
    pushed = MUD.model_copy(update={"weight_on_bit": 8e4})
    friction = wall_friction((weightless(),), survey((0, 90, 40), (900, 90, 100)), pushed).kinetic
    assert friction == pytest.approx([0.25 * 8e4 * 0.084 * math.pi / 3], rel=1e-12)


def test_weight_takes_from_the_side_force_of_tension_where_the_well_builds() -> None:
    """In a building arc N = |F/R − w sin I|, with F = w R (sin I_bit − sin I) − weight on bit."""
    radius, weight_on_bit = 400.0, 3e4
    length = radius * math.pi / 3
    pipe = PIPE.model_copy(update={"length": length})
    w = buoyed_weight(pipe, 1200)
    lies = contact(
        (pipe,),
        well_path(survey((0, 0, 0), (length, 60, 0))),
        MUD.model_copy(update={"weight_on_bit": weight_on_bit}),
    )
    angle = lies.depth / radius
    tension = w * radius * (math.sin(math.pi / 3) - np.sin(angle)) - weight_on_bit
    assert lies.tension == pytest.approx(tension, rel=1e-9)
    assert lies.side_force == pytest.approx(np.abs(tension / radius - w * np.sin(angle)), rel=1e-9)


def test_a_vertical_hole_has_no_friction() -> None:
    mud = MUD.model_copy(update={"weight_on_bit": 2e5})
    friction = wall_friction((PIPE, COLLAR), survey((0, 0, 0), (1000, 0, 123)), mud)
    assert not friction.kinetic.any()
    assert not friction.static.any()


def test_without_a_survey_friction_is_as_told_per_metre() -> None:
    rough = PIPE.model_copy(update={"coulomb_friction": 2.0, "static_friction": 3.0})
    friction = wall_friction((rough, COLLAR), (), None)
    assert friction.kinetic.tolist() == [1800, 0]
    assert friction.static.tolist() == [2700, 0]


KINKS = 0.2
"""What a cell costs, N·m, in which |N| has a kink: where the string changes sides of the hole."""


@given(STRINGS, surveys(), WELLBORES)
def test_the_naive_twin_agrees(string: tuple[Component, ...], well: Survey, wellbore: Wellbore) -> None:
    friction = wall_friction(string, well, wellbore).kinetic
    naive = wall_torque(string, well, wellbore, step=1.0)
    assert friction == pytest.approx(naive, rel=1e-4, abs=KINKS)


@given(STRINGS, surveys(), WELLBORES)
def test_the_cells_are_fine_enough(string: tuple[Component, ...], well: Survey, wellbore: Wellbore) -> None:
    coarse = wall_friction(string, well, wellbore).kinetic
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wall, "CELL", wall.CELL / 20)
        fine = wall_friction(string, well, wellbore).kinetic
    assert coarse == pytest.approx(fine, rel=1e-6, abs=KINKS)


@given(STRINGS, surveys(), WELLBORES)
def test_friction_is_never_negative_and_static_holds_more(
    string: tuple[Component, ...], well: Survey, wellbore: Wellbore
) -> None:
    friction = wall_friction(string, well, wellbore)
    assert (friction.kinetic >= 0).all()
    assert (friction.static >= friction.kinetic).all()


@given(STRINGS, surveys(), WELLBORES, st.floats(-3, 3))
def test_where_north_lies_does_not_matter(
    string: tuple[Component, ...], well: Survey, wellbore: Wellbore, turn: float
) -> None:
    turned = tuple(s.model_copy(update={"azimuth": s.azimuth + turn}) for s in well)
    ours = wall_friction(string, well, wellbore).kinetic
    assert wall_friction(string, turned, wellbore).kinetic == pytest.approx(ours, rel=1e-9, abs=1e-6)


@given(STRINGS, surveys(), WELLBORES)
def test_more_stations_on_the_same_arcs_change_nothing(
    string: tuple[Component, ...], well: Survey, wellbore: Wellbore
) -> None:
    path = well_path(well)
    between = path.depth[:-1] + np.diff(path.depth) * 0.4
    more = [
        Station(
            measured_depth=float(depth),
            inclination=math.atan2(math.hypot(north, east), down),
            azimuth=math.atan2(east, north),
        )
        for depth, (north, east, down) in zip(between, direction(path, between)[0], strict=True)
    ]
    finer = tuple(sorted((*well, *more), key=lambda station: station.measured_depth))
    ours = wall_friction(string, well, wellbore).kinetic
    assert wall_friction(string, finer, wellbore).kinetic == pytest.approx(ours, rel=1e-6, abs=KINKS)


@given(STRINGS, surveys(), st.floats(1, 2400), st.floats(1, 2400))
def test_friction_off_bottom_goes_with_the_weight_in_mud_so_heavier_mud_gives_less(
    string: tuple[Component, ...], well: Survey, light: float, heavy: float
) -> None:
    assume(light < heavy)
    in_light, in_heavy = (
        wall_friction(string, well, MUD.model_copy(update={"mud_density": mud})).kinetic
        for mud in (light, heavy)
    )
    assert in_heavy * (7850 - light) == pytest.approx(in_light * (7850 - heavy), rel=1e-9)
    assert (in_heavy <= in_light).all()


@given(STRINGS, surveys(), WELLBORES)
def test_tension_at_the_top_is_the_weight_by_true_depth_less_that_on_bit(
    string: tuple[Component, ...], well: Survey, wellbore: Wellbore
) -> None:
    path = well_path(well)
    lies = contact(string, path, wellbore)
    weights = np.array([buoyed_weight(part, wellbore.mud_density) for part in string])
    drop = direction(path, lies.depth)[0][:, 2] * lies.span
    hangs = (weights[lies.part] * drop).sum()
    down = float(weights[0] * vertical_depth(path, lies.depth[:1])[0])
    assert lies.tension[0] + down == pytest.approx(hangs - wellbore.weight_on_bit, rel=1e-6, abs=1)
    assert lies.span.sum() == pytest.approx(sum(part.length for part in string))


@given(STRINGS, surveys(), WELLBORES, st.floats(50, 400))
def test_sections_take_up_all_friction(
    string: tuple[Component, ...], well: Survey, wellbore: Wellbore, section_length: float
) -> None:
    line = cut(string, 1e-3, section_length, well, wellbore)
    friction = wall_friction(string, well, wellbore)
    assert line.kinetic.sum() == pytest.approx(friction.kinetic.sum(), rel=1e-6, abs=KINKS)
    assert line.static.sum() == pytest.approx(friction.static.sum(), rel=1e-6, abs=KINKS)


def test_friction_is_gathered_where_the_well_bends() -> None:
    bent = survey((0, 0, 0), (300, 0, 0), (450, 30, 0), (900, 30, 0))
    line = cut((PIPE,), 1e-3, 150, bent, MUD)
    assert len(line.impedance) == 6
    assert not line.kinetic[:2].any()
    assert line.kinetic[3] > line.kinetic[4] > 0


def test_a_smooth_wall_is_no_reason_to_cut() -> None:
    smooth = MUD.model_copy(update={"friction_factor": 0.0, "static_friction_factor": 0.0})
    assert len(cut((PIPE,), 1e-3, 150, survey((0, 0, 0), (900, 30, 0)), smooth).impedance) == 1


def test_a_string_that_grows_rubs_at_its_new_depth() -> None:
    """Its top stays at surface: the collar is pushed on from the vertical hole into the bend."""
    bent = survey((0, 0, 0), (1000, 0, 0), (1600, 60, 0))
    short, long = (
        wall_friction((PIPE.model_copy(update={"length": length}), COLLAR), bent, MUD).kinetic
        for length in (800.0, 1400.0)
    )
    assert not short.any()
    assert long[1] > 0


def test_pipe_weighs_what_tables_say() -> None:
    """5 in, 19.5 lb/ft drill pipe weighs 17.93 lb/ft without its tool joints (API RP 7G)."""
    weight = 17.93 * 4.4482216 / 0.3048
    assert component.cross_section(PIPE) * PIPE.density * GRAVITY == pytest.approx(weight, rel=2e-3)
    assert buoyed_weight(PIPE, PIPE.density / 2) == pytest.approx(weight / 2, rel=2e-3)
