"""What the depths of bit and hole tell, and what the driller may say instead."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.strings import COLLAR, PIPE, rig
from vsensor.commands import Undo, obey
from vsensor.depth import DEEPEST_M, MOST_STANDS, SLACK_M, Depths
from vsensor.depth.belief import LASTING_S, SILENT_S, STEP_M
from vsensor.grid import NS
from vsensor.messages import SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH, Sample
from vsensor.messages.vsensor_pb2 import BAD

RIG = rig(PIPE, COLLAR)
LENGTH, STAND = PIPE.length + COLLAR.length, 28.5


def at(seconds: float, value: float) -> Sample:
    return Sample(time_ns=round(seconds * NS), value=value)


def tell(known: Depths, topic: str, values: list[float], begins: int = 0) -> None:
    """One depth a second."""
    for second, value in enumerate(values, begins):
        known.take(topic, at(second, value))


NOW = 4 * NS
FOR_LONG = 5
"""So many depths, one a second, are believed."""


def depths(*told: tuple[str, float]) -> Depths:
    """Each told from 0 to 4 s."""
    known = Depths(RIG)
    for topic, value in told:
        tell(known, topic, [value] * FOR_LONG)
    return known


def test_the_bit_is_off_bottom_where_it_hangs_above_the_hole() -> None:
    assert not depths().off_bottom(NOW)
    assert not depths((SURFACE_BIT_DEPTH, LENGTH - 9)).off_bottom(NOW)
    lifted = depths((SURFACE_BIT_DEPTH, LENGTH - 9), (SURFACE_HOLE_DEPTH, LENGTH - 8))
    assert lifted.off_bottom(NOW)
    drilling = depths((SURFACE_BIT_DEPTH, LENGTH - 8.4), (SURFACE_HOLE_DEPTH, LENGTH - 8))
    assert not drilling.off_bottom(NOW)


LIFTED = ((SURFACE_BIT_DEPTH, LENGTH - 9), (SURFACE_HOLE_DEPTH, LENGTH - 4))


@pytest.mark.parametrize("silent", [SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH])
@pytest.mark.parametrize(("period_s", "lasts_s"), [(0.1, 5), (1, 5), (5, 15), (10, 30), (20, 30)])
def test_a_bit_whose_depth_is_no_longer_told_is_not_known_to_be_off_bottom(
    silent: str, period_s: float, lasts_s: int
) -> None:
    known = Depths(RIG)
    for number in range(100):
        for topic, value in LIFTED:
            if number < 50 or topic != silent:
                known.take(topic, at(number * period_s, value))
        last = round((49 * period_s + lasts_s) * NS)
        if (number + 1) * period_s * NS > last:
            break
    assert known.off_bottom(last)
    assert not known.silent(last)
    assert not known.off_bottom(last + 1)
    assert known.silent(last + 1)
    times = np.array([last - 1, last, last + 1], np.int64)
    assert known.off_bottom_at(times).tolist() == [True, True, False]

    for number in range(100, 200):
        for topic, value in LIFTED:
            known.take(topic, at(number * period_s, value))
    assert known.off_bottom(round(199 * period_s * NS))


def test_nor_one_whose_depths_are_of_another_time() -> None:
    """A depth channel by a clock of its own, or a surface whose clock was set back."""
    known = depths(*LIFTED)
    for hours in (-1, 1):
        assert not known.off_bottom(NOW + hours * 3600 * NS)
        assert known.silent(NOW + hours * 3600 * NS)


def test_silence_takes_nothing_from_a_command() -> None:
    known = depths(*LIFTED)
    known.command(True)
    assert known.off_bottom(NOW + 3600 * NS)
    assert known.off_bottom_at(np.array([NOW, NOW + 3600 * NS])).tolist() == [True, True]


def test_where_no_depth_was_ever_told_none_is_missed() -> None:
    assert not Depths(RIG).silent(NOW)


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


@pytest.mark.parametrize("wrong", [[LENGTH - 150], [LENGTH - 150] * 3, [0.0, LENGTH + 100], [LENGTH + 900]])
@pytest.mark.parametrize("period_s", [0.01, 1.0])
def test_a_few_wrong_depths_neither_cut_the_string_nor_lift_the_bit(
    wrong: list[float], period_s: float
) -> None:
    known = depths((SURFACE_BIT_DEPTH, LENGTH - 9), (SURFACE_HOLE_DEPTH, LENGTH - 9))
    for number, value in enumerate([LENGTH - 9, *wrong, LENGTH - 9, *wrong, LENGTH - 9]):
        seconds = 4 + number * period_s
        known.take(SURFACE_BIT_DEPTH, at(seconds, value))
        known.take(SURFACE_HOLE_DEPTH, at(seconds, LENGTH - 9))
        assert not known.off_bottom(round(seconds * NS))
        assert not known.at_odds
    assert (known.longer_by(), known.length) == (0, LENGTH)
    assert known.refused == 2 * len(wrong)


def test_nor_do_wrong_ones_at_the_start() -> None:
    known = Depths(RIG)
    tell(known, SURFACE_BIT_DEPTH, [LENGTH - 150, LENGTH - 9, LENGTH - 150, *[LENGTH - 9] * FOR_LONG])
    assert (known.longer_by(), known.refused) == (0, 3)


@pytest.mark.parametrize("period_s", [0.01, 0.1, 1.0, 10.0])
def test_a_connection_that_the_depth_tells_by_a_leap_is_followed_within_seconds(period_s: float) -> None:
    known = Depths(RIG)
    for number in range(round(LASTING_S / period_s) + 2):
        known.take(SURFACE_BIT_DEPTH, at(number * period_s - 20, LENGTH))
    number, longer = 0, 0.0
    while not longer:
        known.take(SURFACE_BIT_DEPTH, at(number * period_s, LENGTH + STAND))
        longer = known.longer_by()
        number += 1
    assert longer == STAND
    assert (number - 1) * period_s <= LASTING_S + period_s


def test_a_bit_that_is_run_in_is_followed_at_once() -> None:
    """Half a metre a second, past where the string would be too short."""
    known = depths((SURFACE_BIT_DEPTH, LENGTH))
    for second in range(5, 60):
        known.take(SURFACE_BIT_DEPTH, at(second, LENGTH + 0.5 * (second - 4)))
        deeper = 0.5 * (second - 4)
        assert known.length == LENGTH + (STAND if deeper > SLACK_M else 0)


def test_a_depth_that_comes_late_is_passed_over() -> None:
    known = depths(*LIFTED)
    known.take(SURFACE_BIT_DEPTH, at(3.5, LENGTH - 4))
    assert known.off_bottom(NOW)


@given(
    st.lists(
        st.tuples(
            st.sampled_from([SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH]),
            st.floats(LENGTH - STEP_M, LENGTH + STEP_M)
            | st.floats(LENGTH - 3 * STAND, LENGTH + 3 * STAND)
            | st.sampled_from([math.nan, 0.0]),
            st.floats(-1.0, SILENT_S + 1),
        ),
        max_size=20,
    )
)
def test_a_depth_settles_only_where_bit_and_string_stay_as_they_are(
    told: list[tuple[str, float, float]],
) -> None:
    """And where no silence could change that: so while the bit is told to be lifted none settles."""
    plain, settling = Depths(RIG), Depths(RIG)
    seconds = 0.0
    for topic, value, later in told:
        seconds += later
        sample = at(seconds, value)
        before = settling.save()
        plain.take(topic, sample)
        settled = settling.settles(topic, sample)
        if settled:
            assert plain.length == before["length"]
            assert not plain.off_bottom(round(seconds * NS))
        else:
            assert settling.save() == before
            settling.take(topic, sample)
        assert settling.save() == plain.save()
        assert (settling.refused, settling.at_odds) == (plain.refused, plain.at_odds)


def test_a_depth_that_no_connection_explains_is_at_odds_and_changes_nothing() -> None:
    known = depths((SURFACE_BIT_DEPTH, 2 * LENGTH))
    assert known.at_odds
    assert known.longer_by() == 0
    tell(known, SURFACE_BIT_DEPTH, [LENGTH] * FOR_LONG, FOR_LONG)
    assert not known.at_odds


@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0, 1e9])
def test_what_is_no_depth_is_refused_and_counted(value: float) -> None:
    known = Depths(RIG)
    known.take(SURFACE_BIT_DEPTH, Sample(value=value))
    assert (known.refused, known.longer_by(), known.at_odds) == (1, 0, False)
    known.take(SURFACE_BIT_DEPTH, None)
    known.take(SURFACE_BIT_DEPTH, Sample(value=LENGTH, quality=BAD))
    assert known.refused == 3


def depths_say(known: Depths) -> bool:
    return known.off_bottom(NOW)


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
        ("shorter 150 m", "no pipe would be left"),
        ("longer 28500 m", "28500.0 m are more than 285.0 m, 10 stands, at a time"),
        ("shorter 28500 m", "28500.0 m are more than 285.0 m"),
    ],
)
def test_what_cannot_be_done_is_refused_with_what_would_be_right(words: str, told: str) -> None:
    """On a string of a short pipe above a long one, so that not much of it may be taken off."""
    known = Depths(rig(PIPE.model_copy(update={"length": 150.0}), PIPE))
    with pytest.raises(ValueError, match=told):
        obey(words, known)
    assert known.length == LENGTH


def test_no_string_is_made_longer_than_any_well_is_deep() -> None:
    known = Depths(RIG)
    while known.length <= DEEPEST_M - 285:
        obey("longer 285 m", known)
    length = known.length
    with pytest.raises(ValueError, match=r"the string would be 20\d\d\d\.\d m long: no well is deeper"):
        obey("longer 285 m", known)
    assert known.length == length


def test_what_was_told_is_taken_back_in_steps_that_are_obeyed() -> None:
    known, undo = Depths(RIG), Undo()
    for words in ["longer 280.1 m", "longer 30 m", "off bottom", "shorter 3 m", "longer 250 m"]:
        obey(words, known)
        undo.note(words)
    back = undo.words()
    assert back[-1] == "by depths"
    for words in back:
        obey(words, known)
    assert known.length == pytest.approx(LENGTH, abs=1e-9)
    assert not known.off_bottom(NOW)
    assert undo.words() == []
