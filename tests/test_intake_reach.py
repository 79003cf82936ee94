"""A speed that inertia cannot have let it become is refused, however often it is told."""

import json
import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.strings import DRIVE, PIPE, rig
from tests.test_arrivals import as_one_by_one
from tests.test_intake import BEGUN, MS, S, T, ticks
from tests.test_intake_ahead import refused
from vsensor.intake import Input, Intake, stretch
from vsensor.messages import Sample
from vsensor.quality import Reason

HEAVY = rig(PIPE, top_drive=DRIVE | {"inertia": 2500.0})
LIGHTEST = rig(PIPE, top_drive=DRIVE | {"inertia": 0.0})
DROPPED = range(1000, 1050)
"""Half a second without a speed at 100 Hz."""


def turned(count: int = 2000) -> list[float]:
    """Speed, rad/s, of a string that is turned by a drive that swings a little."""
    noise = np.random.default_rng(2).normal(size=count).tolist()
    return [12 + math.sin(k / 80) + 0.015 * draw for k, draw in enumerate(noise)]


def feed(speeds: Iterable[float]) -> list[tuple[str, Sample]]:
    return [
        (topic, Sample(time_ns=BEGUN + 10 * MS * k, value=value, sequence=k))
        for k, speed in enumerate(speeds)
        for topic, value in ((T, 5e3 + k % 7), (S, speed))
    ]


def dropped(at: Iterable[int], value: float = 0.0) -> list[float]:
    speeds = turned()
    for k in at:
        speeds[k] = value
    return speeds


def told(speeds: Iterable[float], intake: Intake) -> list[Input]:
    return ticks(feed(speeds), intake)


@pytest.mark.parametrize("value", [0.0, -7.5, 50.0])
def test_a_channel_that_drops_out_is_silent_until_it_comes_back(value: float) -> None:
    intake = Intake(HEAVY)
    given_out = told(dropped(DROPPED, value), intake)
    assert refused(intake, S) == {"strays": len(DROPPED)}
    assert all(10 < tick.motor_speed < 14 for tick in given_out)
    silent = [tick.number for tick in given_out if tick.reasons & Reason.STALE_SPEED]
    assert silent
    assert set(silent) <= set(DROPPED)
    assert {tick.reasons for tick in given_out if tick.number not in DROPPED} == {Reason(0)}


def test_one_that_stays_where_it_cannot_be_is_believed_after_a_while() -> None:
    intake = Intake(HEAVY)
    moved = [speed + 18 if k >= 1000 else speed for k, speed in enumerate(turned())]
    given_out = told(moved, intake)
    assert 200 <= intake.channels[S].counts.strays <= 203
    assert [tick.motor_speed for tick in given_out[1210:]] == moved[1210:]
    assert not any(tick.reasons for tick in given_out[1210:])


def test_a_brake_is_no_leap() -> None:
    """From 12 rad/s to rest in a fifth of a second."""
    braked = [12.0] * 500 + [12.0 - 0.6 * k for k in range(20)] + [0.0] * 500
    intake = Intake(HEAVY)
    assert [tick.motor_speed for tick in told(braked, intake)] == braked
    assert refused(intake, S) == {}


def test_what_has_no_inertia_may_leap() -> None:
    intake = Intake(LIGHTEST)
    given_out = told(dropped(DROPPED), intake)
    assert refused(intake, S) == {}
    assert given_out[1020].motor_speed == 0


spells = st.lists(
    st.tuples(st.sampled_from([0.0, 0.3, 1.0, 2.2, 12.0, 14.0, 50.0]), st.sampled_from([1, 2, 5, 30, 250])),
    max_size=8,
)


@settings(max_examples=30)
@given(spells, st.sampled_from([3, 50, 10_000]), st.integers(0, 400))
def test_by_columns_and_gone_on_with_it_is_the_same(
    levels: list[tuple[float, int]], cut: int, split: int
) -> None:
    fed = feed([12.0] + [level + k % 3 / 100 for level, count in levels for k in range(count)])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stretch, "FEWEST", 4)
        as_one_by_one(HEAVY, fed, cut, split)


@pytest.mark.parametrize("damaged", [[0, 1.0], [0, math.inf, 0], [5, 1.0, 6], [1 << 63, 1.0, 0]])
def test_a_damaged_state_is_refused_by_name(damaged: list[float]) -> None:
    saved = Intake(HEAVY).save()
    saved["channels"][S]["apart"] = damaged
    with pytest.raises(ValueError, match=r"apart.* holds .* is right"):
        Intake(HEAVY).restore(json.loads(json.dumps(saved)))
