"""Reasons and the verdict on them: what may be used, what with care, what not at all."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.messages.vsensor_pb2 import Quality as QualityMessage
from vsensor.quality import Quality, Reason, verdict

WITH_CARE = set(Reason) - {Reason.WARMING_UP}
BOTH_STALE = {Reason.STALE_TORQUE, Reason.STALE_SPEED}
"""One channel alone still drives the string under the load law; none does not."""
reasons = st.sets(st.sampled_from(list(Reason)))


def combined(flags: set[Reason]) -> Reason:
    return Reason(sum(flags))


def test_without_a_reason_a_number_is_good() -> None:
    assert verdict(Reason(0)) == Quality.GOOD


@pytest.mark.parametrize("flag", sorted(WITH_CARE))
def test_one_reason_asks_for_care(flag: Reason) -> None:
    assert verdict(flag) == Quality.UNCERTAIN


@given(reasons)
def test_while_warming_up_or_with_both_channels_silent_a_number_must_not_be_used(flags: set[Reason]) -> None:
    unusable = Reason.WARMING_UP in flags or flags >= BOTH_STALE
    assert (verdict(combined(flags)) == Quality.BAD) == unusable


@given(reasons, reasons)
def test_a_further_reason_never_makes_it_better(flags: set[Reason], more: set[Reason]) -> None:
    assert verdict(combined(flags | more)) >= verdict(combined(flags))


@given(reasons)
def test_words_name_each_reason_once(flags: set[Reason]) -> None:
    named = [word for word in combined(flags).words().split(", ") if word]
    assert sorted(named) == sorted(str(flag.name).lower().replace("_", " ") for flag in flags)


def test_words_are_plain() -> None:
    assert (Reason.STALE_TORQUE | Reason.GAP_BRIDGED).words() == "gap bridged, stale torque"


@pytest.mark.parametrize("quality", list(Quality))
def test_grades_are_the_same_on_the_bus(quality: Quality) -> None:
    assert int(QualityMessage.Value(quality.name)) == int(quality)


def test_flags_are_those_of_recorded_sessions() -> None:
    """A session says its reasons in these bits; one that moved would turn old recordings into lies."""
    assert {flag.name: int(flag) for flag in Reason} == {
        "WARMING_UP": 1,
        "GAP_BRIDGED": 2,
        "STALE_TORQUE": 4,
        "STALE_SPEED": 8,
        "SOURCE_UNCERTAIN": 16,
        "STRING_CHANGED": 32,
        "FROZEN_TORQUE": 64,
        "FROZEN_SPEED": 128,
        "IN_SLIPS": 256,
        "TORQUE_TOO_LOW": 512,
    }
