"""The large figures: nothing that must not be trusted is shown large, and colours say what they mean."""

import io

import numpy as np
import pytest
from PIL import Image

from tests.view_rig import BEGUN_NS, estimate, profile, status, tick
from vsensor.messages import Estimate, Message
from vsensor.messages.vsensor_pb2 import BAD
from vsensor.view.batches import Colour, Picture
from vsensor.view.glance import GAP, TILES, Glance
from vsensor.view.palette import GREEN, ORANGE, VERMILION, YELLOW
from vsensor.view.plots import Drive
from vsensor.view.units import Units

BIT, SURFACE, TORQUE, ROUGHNESS, TRUST = range(5)


def glance(*given: Message, units: Units | None = None) -> Glance:
    part = Glance(units or Units(), Drive())
    for message in given:
        part.hear(message, BEGUN_NS)
    return part


def tile(part: Glance, number: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    picture = np.asarray(Image.open(io.BytesIO(part.picture())).convert("RGB"))
    left = sum(TILES[:number]) + GAP * number
    return picture[:, left : left + TILES[number]]


def share(part: Glance, number: int, colour: Colour) -> float:
    """How much of a tile is of a colour; the picture's palette moves it a little."""
    return float((np.abs(tile(part, number).astype(int) - colour[:3]).max(axis=2) <= 12).mean())


def turning(number: int = 50) -> Estimate:
    return estimate(number)


def test_a_bit_that_turns_is_told_in_a_large_figure_on_quiet_ground() -> None:
    part = glance(tick(50), turning(), status(), profile(50))
    assert share(part, BIT, ORANGE) > 0.02
    assert share(part, BIT, VERMILION) == 0


def test_a_bit_that_stands_while_the_string_turns_is_an_alarm() -> None:
    part = glance(tick(300), estimate(300), status())
    assert share(part, BIT, VERMILION) > 0.5


def test_a_stick_that_is_near_asks_for_care() -> None:
    soon = turning()
    soon.stick_in_s = 0.7
    assert share(glance(tick(50), soon, status()), BIT, YELLOW) > 0.5


@pytest.mark.parametrize(("severity", "colour"), [(0.2, GREEN), (0.7, YELLOW), (1.3, VERMILION)])
def test_severity_is_a_coloured_state(severity: float, colour: Colour) -> None:
    rough = status()
    rough.severity = severity
    assert share(glance(turning(), rough), ROUGHNESS, colour) > 0.5


@pytest.mark.parametrize(("margin", "colour"), [(0.6, GREEN), (0.05, YELLOW), (-0.1, VERMILION)])
def test_the_bar_of_torque_has_the_colour_of_the_margin(margin: float, colour: Colour) -> None:
    near = profile(50)
    near.weakest_margin = margin
    assert share(glance(tick(50), turning(), near), TORQUE, colour) > 0.02


def test_a_bad_estimate_is_not_shown_in_figures() -> None:
    def bad(number: int) -> Estimate:
        told = estimate(number)
        told.quality = BAD
        return told

    one, other = (glance(tick(50), bad(number), status()) for number in (20, 90))
    np.testing.assert_array_equal(tile(one, BIT), tile(other, BIT))
    assert share(one, TRUST, VERMILION) > 0.5
    assert share(one, ROUGHNESS, VERMILION) == 0


def test_where_nothing_comes_any_more_nothing_old_is_shown() -> None:
    one, other = (glance(tick(number), estimate(number), status()) for number in (20, 90))
    for part in (one, other):
        part.silent(5.0, BEGUN_NS)
    assert one.picture() == other.picture()
    assert share(one, TRUST, VERMILION) > 0.5


def test_it_says_of_when_it_is() -> None:
    """A page that is slow to draw shows the same a minute later."""
    one, other = (glance(tick(50), turning(), status()) for _ in range(2))
    other.at_ns += 60 * 10**9
    assert (tile(one, TRUST) != tile(other, TRUST)).any()
    assert share(other, TRUST, GREEN) > 0.5


def test_before_anything_is_known_there_is_a_picture_that_claims_nothing() -> None:
    for number in range(5):
        assert share(glance(), number, GREEN) == 0
    silent = glance()
    silent.silent(5.0, BEGUN_NS)
    for number in (BIT, SURFACE, TORQUE):
        apart = np.abs(tile(glance(), number).astype(int) - tile(silent, number))
        assert apart.max() <= 64  # the picture's palette moves colours a little, another figure by far more


def test_other_units_are_other_figures() -> None:
    one, other = (glance(tick(50), turning(), units=units) for units in (Units(), Units("rad/s", "kft*lbf")))
    for number in (BIT, SURFACE, TORQUE):
        assert not np.array_equal(tile(one, number), tile(other, number))


def test_it_is_drawn_four_times_a_second_where_it_changes() -> None:
    part = glance()
    drawn = 0
    for number in range(100):
        for message in (tick(number), estimate(number)):
            part.hear(message, tick(number).time_ns)
        drawn += sum(isinstance(batch, Picture) for batch in part.batches())
    assert drawn == 4
