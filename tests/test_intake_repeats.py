"""Readings that are passed on more often than they are read: what repeats one is none."""

import json
import math
from collections.abc import Callable, Iterable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.test_arrivals import as_one_by_one, by_columns_alone
from tests.test_intake import BEGUN, MS, SMALL, S, T, ticks
from tests.test_intake_ahead import refused
from vsensor.intake import Intake, stretch
from vsensor.intake.repeats import BLOCK
from vsensor.messages import Sample
from vsensor.quality import Reason

Fed = list[tuple[str, Sample]]
TICKS = 1500
KNOWN = 10 * (BLOCK + 2)
"""Ticks after which it is known that readings at 10 Hz are told ten times."""


def readings(seed: int = 1) -> list[float]:
    """Torque, N·m, that swings and is noisy, at each tick of 100 Hz."""
    noise = np.random.default_rng(seed).normal(size=TICKS).tolist()
    return [8e3 + 2e3 * math.sin(k / 60) + 80 * draw for k, draw in enumerate(noise)]


def held(values: list[float], beat: int) -> list[float]:
    return [values[k - k % beat] for k in range(len(values))]


def feed(torques: Iterable[float | None]) -> Fed:
    """Both channels at 100 Hz; no torque where there is None."""
    return [
        (topic, Sample(time_ns=BEGUN + 10 * MS * k, value=value))
        for k, torque in enumerate(torques)
        for topic, value in ((T, torque), (S, 9 + k % 97 / 1e3))
        if value is not None
    ]


@pytest.mark.parametrize("beat", [2, 3, 10, 20])
def test_what_is_told_often_is_read_as_what_is_told_once(beat: int) -> None:
    values = readings()
    once = ticks(feed(value if k % beat == 0 else None for k, value in enumerate(values)))
    often = Intake(SMALL)
    told = ticks(feed(held(values, beat)), often)
    known = beat * (BLOCK + 2)
    assert often.beats == (beat, 0)
    assert [tick.motor_torque for tick in told[known : len(once)]] == [
        tick.motor_torque for tick in once[known:]
    ]
    assert not any(tick.reasons for tick in told)
    assert refused(often, T) == {}
    assert often.channels[T].counts.accepted == often.channels[T].counts.received


def test_readings_by_another_clock_take_now_one_sample_more_now_one_less() -> None:
    values = readings()
    uneven = [values[int(int(k / 8.3) * 8.3)] for k in range(TICKS)]
    intake = Intake(SMALL)
    told = [tick.motor_torque for tick in ticks(feed(uneven), intake)]
    assert intake.beats == (9, 0)
    assert not any(a == b for a, b in zip(told[KNOWN:], told[KNOWN + 1 :], strict=False))


def in_coarse_steps() -> list[float]:
    return [round(value / 100) * 100.0 for value in readings()]


def in_very_coarse_steps() -> list[float]:
    return [round(value / 400) * 400.0 for value in readings()]


def told_as_it_changes() -> list[float]:
    """For two samples, for twenty, or for any number between."""
    chance = np.random.default_rng(3)
    values = np.repeat(readings(), chance.integers(2, 20, TICKS))
    told: list[float] = values[:TICKS].tolist()
    return told


def too_seldom() -> list[float]:
    """A reading told for 0.4 s: a line over that is no longer what was measured."""
    return held(readings(), 40)


@pytest.mark.parametrize(
    "told", [readings, in_coarse_steps, in_very_coarse_steps, told_as_it_changes, too_seldom]
)
def test_what_is_no_reading_told_again_passes_unchanged(told: Callable[[], list[float]]) -> None:
    values, intake = told(), Intake(SMALL)
    assert [tick.motor_torque for tick in ticks(feed(values), intake)] == values
    assert intake.beats == (0, 0)


def test_one_that_comes_twice_is_doubled_and_no_repeat() -> None:
    fed = [each for each in feed(readings()) for _ in range(2)]
    intake = Intake(SMALL)
    ticks(fed, intake)
    assert intake.beats == (0, 0)
    assert refused(intake, T) == {"doubled": TICKS}


def test_a_reading_that_stays_is_believed_and_one_that_is_new_at_once() -> None:
    """A string in slips, its torque to the last digit the same, for longer than any gap that is allowed."""
    intake, values = Intake(SMALL), held(readings(), 10)
    values[600:1200] = [values[600]] * 600
    told = ticks(feed(values), intake)
    assert {tick.motor_torque for tick in told[610:1190]} == {values[600]}
    assert intake.restarts == 0
    flagged = {Reason(tick.reasons) for tick in told}
    assert flagged <= {Reason(0), Reason.FROZEN_TORQUE}
    assert told[1200].motor_torque == values[1200]


def test_a_wild_reading_does_not_bear_itself_out() -> None:
    intake, values = Intake(SMALL), held(readings(), 10)
    values[800:810] = [-3e4] * 10
    told = ticks(feed(values), intake)
    assert refused(intake, T) == {"strays": 1}
    assert all(5e3 < tick.motor_torque < 11e3 for tick in told)


def test_once_each_sample_is_a_reading_again_each_counts() -> None:
    values = readings()
    intake = Intake(SMALL)
    told = ticks(feed(held(values, 10)[:700] + values[700:]), intake)
    assert intake.beats == (0, 0)
    assert [tick.motor_torque for tick in told[700:]] == values[700:]


def test_a_publisher_that_counts_anew_amid_a_reading_loses_none() -> None:
    intake, values = Intake(SMALL), held(readings(), 10)
    fed = feed(values)
    for k, (_, sample) in enumerate(fed):
        sample.sequence = k // 2 if k < 2 * 705 else k // 2 - 705
    ticks(fed, intake)
    assert intake.channels[T].counts.lost == 0
    assert intake.channels[T].sequence.due == TICKS - 705


spells = st.lists(st.tuples(st.integers(1, 12), st.sampled_from([1, 5, 40, 70]), st.booleans()), max_size=4)


def spelled(levels: list[tuple[int, int, bool]], seed: int) -> list[float]:
    """Readings told so and so often, so and so many of them, every other one once more or not."""
    chance = np.random.default_rng(seed)
    return [
        value
        for often, count, uneven in levels
        for k in range(count)
        for value in [float(chance.normal(8e3, 1e3))] * (often + (uneven and k % 2))
    ]


@settings(max_examples=30)
@given(spells, st.integers(0, 9), st.sampled_from([3, 50, 10_000]), st.integers(0, 1000))
def test_by_columns_and_gone_on_with_it_is_the_same(
    levels: list[tuple[int, int, bool]], seed: int, cut: int, split: int
) -> None:
    fed = feed([8e3, *spelled(levels, seed)][:800])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stretch, "FEWEST", 4)
        as_one_by_one(SMALL, fed, cut, split)


def test_they_go_by_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    assert by_columns_alone(SMALL, feed(held(readings(), 10)), monkeypatch).beats == (10, 0)


@pytest.mark.parametrize(
    ("at", "value", "said"),
    [
        (0, -1, "a whole number from 0"),
        (1, 1e9, "a number from"),
        (1, None, "a whole number from 0 to 0"),
        (3, 0, "a whole number from 1"),
        (5, [0], "a whole number from 1"),
        (5, [1] * BLOCK, "a list of fewer than 32"),
    ],
)
def test_a_damaged_state_is_refused_by_name(at: int, value: object, said: str) -> None:
    intake = Intake(SMALL)
    ticks(feed(readings()[:50]), intake)
    saved = json.loads(json.dumps(intake.save()))
    saved["channels"][T]["repeats"][at] = value
    with pytest.raises(ValueError, match=rf"repeats.* holds .*{said}"):
        Intake(SMALL).restore(saved)


def test_a_state_of_a_version_that_knew_of_none_is_taken_up() -> None:
    fed = feed(held(readings(), 10))
    intake, other = Intake(SMALL), Intake(SMALL)
    ticks(fed[:20], intake)
    saved = json.loads(json.dumps(intake.save()))
    for channel in saved["channels"].values():
        del channel["repeats"]
    other.restore(saved)
    ticks(fed[20:], other)
    assert other.beats == (10, 0)
