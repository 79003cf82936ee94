"""Charts of the engineer's tab: held against closed forms."""

import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from tests.view_rig import (
    BEGUN_NS,
    COMPLIANCE,
    DEPTHS,
    IMPEDANCE,
    LENGTH,
    description,
    estimate,
    profile,
    status,
)
from vsensor.estimator import load
from vsensor.messages import Estimate, Message, Profile, Status
from vsensor.view.batches import Batch, Labels, Picture, Strokes
from vsensor.view.charts.chart import HEIGHT, WIDTH, Chart, Scale, axis
from vsensor.view.charts.portrait import Portrait, law
from vsensor.view.charts.spacetime import COLUMNS, ROWS, SpaceTime
from vsensor.view.charts.spectrum import Spectrum, amplitudes
from vsensor.view.charts.twist import Twist, twist
from vsensor.view.charts.waves import Waves
from vsensor.view.palette import GROUND
from vsensor.view.part import Part
from vsensor.view.units import Units

FINITE = st.floats(-1e6, 1e6).map(lambda value: round(value, 6))


def drawn(part: Part, *given: Message) -> list[Batch]:
    for message in given:
        part.hear(message, BEGUN_NS)
    return list(part.batches())


def strokes(batches: list[Batch]) -> dict[str, Strokes]:
    return {batch.entity: batch for batch in batches if isinstance(batch, Strokes)}


def labels(batches: list[Batch]) -> list[str]:
    return [text for batch in batches if isinstance(batch, Labels) for text in batch.texts]


@given(FINITE, FINITE)
def test_an_axis_holds_both_ends_with_a_handful_of_ticks_that_can_be_read(one: float, other: float) -> None:
    low, high = sorted((one, other))
    found = axis(low, high)
    slack = 1e-6 * (found.high - found.low)
    assert found.low <= low + slack
    assert found.high >= high - slack
    assert 2 <= len(found.ticks()) <= 7
    assert round(found.step / 10 ** math.floor(math.log10(found.step) + 1e-9)) in (1, 2, 5)


def test_an_axis_does_not_tremble_but_follows() -> None:
    scale = Scale(0.0)
    first = scale.follow(np.array([10.0]))
    assert scale.follow(np.array([9.0])) is first
    assert scale.follow(np.array([11.0])).high > first.high
    assert scale.follow(np.array([0.5, math.nan])).high < first.high


def test_a_chart_puts_its_corners_where_its_frame_is_and_what_is_up_above() -> None:
    chart = Chart("/c", "x", "y")
    list(chart.frame(0, axis(0, 10), axis(0, 4)))
    corners = chart.places(np.array([0.0, 10.0]), np.array([0.0, 4.0]))
    np.testing.assert_allclose(corners, [[0, HEIGHT], [WIDTH, 0]])
    assert list(chart.frame(0, axis(0, 10), axis(0, 4))) == []


def test_the_twist_of_an_even_torque_is_torque_times_length_over_stiffness() -> None:
    depth = np.array([0.0, 400.0, 1000.0])
    turned = twist(depth, np.full(3, 7000.0), np.full(3, COMPLIANCE))
    np.testing.assert_allclose(turned, 7000.0 * COMPLIANCE * depth)


def test_each_component_twists_by_its_own_stiffness() -> None:
    depth = np.array([0.0, 400.0, 400.0, 1000.0])
    turned = twist(depth, np.full(4, 7000.0), np.array([1e-6, 1e-6, 1e-7, 1e-7]))
    assert turned[-1] == pytest.approx(7000.0 * (400e-6 + 600e-7))


def test_the_ribbon_follows_the_well_and_tells_the_turns() -> None:
    batches = drawn(Twist("/t"), description(), profile(0))
    ribbon = strokes(batches)["/t/ribbon"]
    middles = np.array([line.mean(axis=0) for line in ribbon.lines])
    np.testing.assert_allclose(middles[0], [0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(
        middles[-1], [0.5, 0, -0.5], atol=1e-9
    )  # east, north, up; lengths of the string
    turns = (8000 + 3000) / 2 * COMPLIANCE * LENGTH / (2 * math.pi)
    assert f"the bit is {turns:.2f} turns behind the top" in labels(batches)
    assert "shear stress, MPa" in labels(batches)


def test_the_ribbon_is_turned_at_the_bit_by_the_twist() -> None:
    ribbon = strokes(drawn(Twist("/t"), description(), profile(0)))["/t/ribbon"]
    bars = [line[1] - line[0] for line in ribbon.lines]
    units = [bar / np.linalg.norm(bar) for bar in bars]
    # Down to the bend every bar is level, so that the angle between them is the twist between them.
    at, depths = len(bars) // 4, np.array(DEPTHS)
    turned = (8000 * depths - 5000 / LENGTH * depths**2 / 2) * COMPLIANCE
    here = np.interp(at / (len(bars) - 1) * LENGTH, depths, turned)
    assert float(units[0] @ units[at]) == pytest.approx(math.cos(here), abs=1e-6)


def test_without_a_description_there_is_no_telling_how_the_string_lies() -> None:
    assert drawn(Twist("/t"), profile(0)) == drawn(Waves("/w", Units()), profile(0)) == []


def test_waves_add_up_to_twice_the_torque() -> None:
    batches = drawn(Waves("/w", Units()), description(), profile(300))
    down, up = (strokes(batches)[f"/w/{name}"].lines[0][:, 0] for name in ("down", "up"))
    x = axis(*_span(batches))
    waves = [x.low + place / WIDTH * (x.high - x.low) for place in (down, up)]
    np.testing.assert_allclose(waves[0] + waves[1], 2 * np.array(profile(300).torque_nm) / 1e3)
    swing = 2 * IMPEDANCE * np.array(profile(300).speed_rad_s) / 1e3
    np.testing.assert_allclose(waves[0] - waves[1], swing, atol=1e-9)


def _span(batches: list[Batch]) -> tuple[float, float]:
    """What the horizontal axis covers, read from the ticks below the frame."""
    axes = next(batch for batch in batches if isinstance(batch, Labels) and batch.entity.endswith("/axes"))
    below = [text for text, (_, y) in zip(axes.texts, axes.places, strict=True) if HEIGHT < y < HEIGHT + 10]
    ticks = [float(text.replace("−", "-")) for text in below]
    return ticks[0], ticks[-1]


def test_the_law_is_the_estimators() -> None:
    told = Status(law_viscous_nm_s_rad=5.0, law_kinetic_nm=3e3, law_static_nm=8e3, law_stribeck_rad_s=1.5)
    speeds = np.array([-4.0, -0.3, 0.0, 0.2, 1.0, 30.0])
    model = load.Load(inertia_rate=0.0, viscous=5.0, kinetic=3e3, static=8e3, stribeck=1.5)
    np.testing.assert_allclose(law(told, speeds), [load.law(model, float(speed)) for speed in speeds])


def test_the_portrait_has_the_way_of_the_bit_and_the_law() -> None:
    known = status()
    known.law_kinetic_nm, known.law_static_nm, known.law_stribeck_rad_s = 3e3, 8e3, 1.5
    batches = drawn(Portrait("/p", Units(), 30.0), known, *(estimate(number) for number in range(0, 400, 2)))
    found = strokes(batches)
    assert len(found["/p/way"].lines[0]) == 200
    assert len(found["/p/way/law"].lines[0]) > 100
    assert {"bit speed, rpm", "bit torque, kN·m", "learned law"} <= {*labels(batches)}


@given(st.floats(0.3, 3.5), st.floats(0.1, 100), st.floats(-50, 50))
def test_a_sine_is_seen_at_its_frequency_with_its_amplitude(hz: float, swing: float, mean: float) -> None:
    times = np.arange(0, 30, 0.02)
    found_hz, found = amplitudes(times, mean + swing * np.sin(2 * np.pi * hz * times))
    at = found[1:].argmax() + 1
    assert found_hz[at] == pytest.approx(hz, abs=0.5 / 30 + 1e-3)
    assert found[at] == pytest.approx(swing, rel=0.16)  # between two lines Hann's window loses 15 %


def test_the_spectrum_marks_the_modes_that_it_shows() -> None:
    estimates = [estimate(number) for number in range(0, 3000, 2)]
    batches = drawn(Spectrum("/s", Units(), 30.0), description(), *estimates)
    assert [text for text in labels(batches) if text in ("0.25", "0.75", "1.25", "9.00")] == [
        "0.25",
        "0.75",
        "1.25",
    ]
    assert "amplitude, rpm" in labels(batches)
    assert {"/s/top", "/s/top/bit", "/s/modes"} <= {*strokes(batches)}


def pixels(batches: list[Batch]) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    (picture,) = (batch for batch in batches if isinstance(batch, Picture))
    return np.asarray(Image.open(io.BytesIO(picture.png)).convert("RGB"))


def test_depth_goes_down_and_time_across_and_what_is_not_known_is_left_dark() -> None:
    part = SpaceTime("/f", "torque", Units(), 24.0)
    heard = [profile(number) for number in (*range(0, 600, 10), *range(1200, 1800, 10))]
    picture = pixels(drawn(part, *heard))[:, :COLUMNS].astype(int)
    assert picture.shape == (ROWS, COLUMNS, 3)
    known = (picture != GROUND[:3]).any(axis=2)
    assert known[:, -55:].all()
    assert not known[:, -100:-65].any()
    assert known[:, -175:-125].all()
    brightness = picture[:, -1].sum(axis=1)
    assert (np.diff(brightness) <= 1).all()  # torque falls with depth
    assert brightness[0] > brightness[-1] + 200


def test_the_space_time_picture_is_that_of_a_naive_twin() -> None:
    """Column by column: the profile that stands at the column's time, looked up by depth."""
    part = SpaceTime("/f", "speed", Units(), 24.0)
    heard = [profile(number) for number in range(0, 2400, 10)]
    for message in heard:
        part.hear(message, BEGUN_NS)
    field = part._field_at(heard[-1].time_ns)
    for column in (0, 17, 100, COLUMNS - 1):
        speed = heard[column].speed_rad_s[0] * 60 / (2 * math.pi)
        np.testing.assert_allclose(field[:, column], speed, rtol=1e-6, atol=1e-6)


def test_nothing_is_drawn_of_nothing() -> None:
    for part in (
        SpaceTime("/f", "torque", Units(), 30.0),
        Portrait("/p", Units(), 30.0),
        Spectrum("/s", Units(), 30.0),
        Twist("/t"),
    ):
        assert drawn(part, Profile(), Estimate(), Status()) == []
