"""What the depths of bit and hole tell, and what the driller may say instead."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.strings import COLLAR, PIPE, rig
from vsensor.commands import obey
from vsensor.depth import MOST_STANDS, SLACK_M, Depths
from vsensor.messages import SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH, Sample
from vsensor.messages.vsensor_pb2 import BAD

RIG = rig(PIPE, COLLAR)
LENGTH, STAND = PIPE.length + COLLAR.length, 28.5


def depths(*told: tuple[str, float]) -> Depths:
    known = Depths(RIG)
    for topic, value in told:
        known.take(topic, Sample(value=value))
    return known


def test_the_bit_is_off_bottom_where_it_hangs_above_the_hole() -> None:
    assert not depths().off_bottom
    assert not depths((SURFACE_BIT_DEPTH, LENGTH - 9)).off_bottom
    assert depths((SURFACE_BIT_DEPTH, LENGTH - 9), (SURFACE_HOLE_DEPTH, LENGTH - 8)).off_bottom
    assert not depths((SURFACE_BIT_DEPTH, LENGTH - 8.4), (SURFACE_HOLE_DEPTH, LENGTH - 8)).off_bottom


@pytest.mark.parametrize("above", [-SLACK_M, 0.0, 10.0, STAND, STAND + SLACK_M])
def test_a_bit_within_a_stand_below_its_string_says_nothing_of_its_length(above: float) -> None:
    known = depths((SURFACE_BIT_DEPTH, LENGTH - above))
    assert known.longer_by() == 0
    assert known.length == LENGTH


@pytest.mark.parametrize(
    ("above", "stands"),
    [(-SLACK_M - 0.1, 1), (-20.0, 1), (-40.0, 2), (STAND + SLACK_M + 0.1, -1), (70.0, -2)],
)
def test_beyond_that_stands_were_added_or_taken_off(above: float, stands: int) -> None:
    known = depths((SURFACE_BIT_DEPTH, LENGTH - above))
    assert known.longer_by() == pytest.approx(stands * STAND)
    assert known.longer_by() == 0  # told once
    assert known.length == pytest.approx(LENGTH + stands * STAND)
    assert not known.at_odds


@given(st.floats(-MOST_STANDS * STAND, MOST_STANDS * STAND))
def test_whatever_was_added_the_bit_hangs_within_a_stand_of_its_string(deeper: float) -> None:
    bit = LENGTH + deeper
    known = depths((SURFACE_BIT_DEPTH, bit))
    assert -SLACK_M - 1e-6 <= known.length - bit <= STAND + SLACK_M + 1e-6


@given(
    st.lists(
        st.tuples(
            st.sampled_from([SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH]),
            st.floats(LENGTH - 3 * STAND, LENGTH + 3 * STAND) | st.sampled_from([math.nan, 0.0]),
        ),
        max_size=12,
    )
)
def test_a_depth_settles_only_where_bit_and_string_stay_as_they_are(told: list[tuple[str, float]]) -> None:
    plain, settling = Depths(RIG), Depths(RIG)
    for topic, value in told:
        sample = Sample(value=value)
        before = {**settling.save(), "known": dict(settling.save()["known"])}, settling.off_bottom
        plain.take(topic, sample)
        settled = settling.settles(topic, sample)
        assert settled == ((plain.length, plain.off_bottom) == (before[0]["length"], before[1]))
        if not settled:
            assert (settling.save(), settling.off_bottom) == before
            settling.take(topic, sample)
        assert settling.save() == plain.save()
        assert (settling.refused, settling.at_odds) == (plain.refused, plain.at_odds)


def test_a_depth_that_no_connection_explains_is_at_odds_and_changes_nothing() -> None:
    known = depths((SURFACE_BIT_DEPTH, 2 * LENGTH))
    assert known.at_odds
    assert known.longer_by() == 0
    known.take(SURFACE_BIT_DEPTH, Sample(value=LENGTH))
    assert not known.at_odds


@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0, 1e9])
def test_what_is_no_depth_is_refused_and_counted(value: float) -> None:
    known = depths((SURFACE_BIT_DEPTH, value))
    assert (known.refused, known.longer_by(), known.at_odds) == (1, 0, False)
    known.take(SURFACE_BIT_DEPTH, None)
    known.take(SURFACE_BIT_DEPTH, Sample(value=LENGTH, quality=BAD))
    assert known.refused == 3


def depths_say(known: Depths) -> bool:
    return known.off_bottom


def test_the_driller_has_the_last_word_on_the_bit() -> None:
    known = depths((SURFACE_BIT_DEPTH, LENGTH - 9), (SURFACE_HOLE_DEPTH, LENGTH))
    assert obey("on bottom", known) == "the bit is held to be on bottom"
    assert depths_say(known) is False
    obey("Off-Bottom", known)
    assert depths_say(known) is True
    assert obey("by depths", known) == "the depths decide"
    assert depths_say(known) is True


@pytest.mark.parametrize(
    ("words", "longer"), [("longer 28.5 m", 28.5), ("shorter 90 ft", -27.432), ("longer 30", 30)]
)
def test_the_driller_may_tell_of_a_stand(words: str, longer: float) -> None:
    known = Depths(RIG)
    assert f"{LENGTH + longer:.1f} m" in obey(words, known)
    assert known.longer_by() == pytest.approx(longer)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("", "is no command: say"),
        ("higher", "is no command: say"),
        ("longer", "is no command: say"),
        ("longer 3 kg", "does not measure in m"),
        ("longer -3 m", "is no length"),
        ("shorter 1500 m", "no pipe would be left"),
    ],
)
def test_what_cannot_be_done_is_refused_with_what_would_be_right(words: str, told: str) -> None:
    known = Depths(RIG)
    with pytest.raises(ValueError, match=told):
        obey(words, known)
    assert known.length == LENGTH
