"""A reading that has frozen is flagged, a string that stands still is not."""

import json
import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.rigs import RATE, SHORT, samples, simulated
from tests.strings import PIPE, rig
from tests.test_arrivals import as_one_by_one
from tests.test_intake import BEGUN, MS, SMALL, S, T, one, steps, ticks
from vsensor.intake import Intake, stretch
from vsensor.intake.frozen import LASTING_S, MOVED
from vsensor.messages import Sample
from vsensor.offline import Offline
from vsensor.quality import Reason

FROZEN_TICKS = round(LASTING_S * 100)
STALE = Reason.STALE_TORQUE | Reason.STALE_SPEED


def feed(values: Iterable[tuple[float, float]], first: int = 0) -> list[tuple[str, Sample]]:
    """Torque and speed at 100 Hz."""
    return [
        (topic, Sample(time_ns=BEGUN + 10 * MS * k, value=value, sequence=k))
        for k, pair in enumerate(values, first)
        for topic, value in zip((T, S), pair, strict=True)
    ]


def reasons(values: Iterable[tuple[float, float]], **measurement: float) -> list[int]:
    configured = rig(PIPE, measurement=measurement) if measurement else SMALL
    return [tick.reasons for tick in ticks(feed(values), Intake(configured))]


@pytest.mark.parametrize(("of", "reason"), [(0, Reason.FROZEN_TORQUE), (1, Reason.FROZEN_SPEED)])
def test_a_channel_that_repeats_a_value_while_the_other_moves_is_frozen(of: int, reason: Reason) -> None:
    """From three seconds on, while it is not known what is usual, and until it tells another value."""
    moving = [(5e3 * math.sin(k / 50), 5 * math.sin(k / 50)) for k in range(1000)]
    torque, speed = moving[200]
    frozen = [(torque, pair[1]) if of == 0 else (pair[0], speed) for pair in moving[200:700]]
    told = reasons([*moving[:200], *frozen, *moving[700:]])
    since = 200 + FROZEN_TICKS
    assert set(told[:since]) == set(told[700:]) == {Reason(0)}
    assert set(told[since:700]) == {reason}


@pytest.mark.parametrize(("repeats", "since"), [(2, 30), (12, 120)])
def test_what_is_too_long_to_be_usual_the_channel_itself_tells(repeats: int, since: int) -> None:
    """Passed on at 100 Hz, and read once in so many ticks."""
    moving = [(5e3 * math.sin(k // repeats / 7), 5 * math.sin(k / 10)) for k in range(1500)]
    torque, _ = moving[1199]
    told = reasons([*moving[:1200], *((torque, speed) for _, speed in moving[1200:])])
    first = 1200 - repeats  # the last that was read
    assert set(told[: first + since]) == {Reason(0)}
    assert set(told[first + since :]) == {Reason.FROZEN_TORQUE}


def noisy(count: int) -> list[tuple[float, float]]:
    """Torque and speed of a string that is turned, which never repeat themselves."""
    random = np.random.default_rng(3)
    return [
        (5e3 + 80 * random.standard_normal(), 12 + 0.015 * random.standard_normal()) for _ in range(count)
    ]


@pytest.mark.parametrize(("of", "reason"), [(0, Reason.FROZEN_TORQUE), (1, Reason.FROZEN_SPEED)])
def test_the_fourth_time_is_enough_for_a_channel_that_seldom_repeats_itself(of: int, reason: Reason) -> None:
    values = [list(pair) for pair in noisy(3000)]
    spells = [(200, 250), (1300, 1350), (1800, 1808), (2400, 2403)]
    for begun, ended in spells:
        for k in range(begun, ended):
            values[k][of] = values[begun][of]
    told = reasons((torque, speed) for torque, speed in values)
    held = {k for begun, ended in spells[1:] for k in range(begun + 3, ended)}  # at first nothing is known
    assert {k for k, flags in enumerate(told) if flags} == held
    silent = Reason.STALE_SPEED if of else Reason.STALE_TORQUE
    assert {told[k] for k in held} == {reason | silent}


def test_both_frozen_together_are_never_good_and_soon_silent() -> None:
    """A gateway that has lost its source repeats the last of both, with new times."""
    values = noisy(3000)
    values[1300:1400] = [values[1300]] * 100
    values[2000:2008] = [values[2000]] * 8
    frozen = Reason.FROZEN_TORQUE | Reason.FROZEN_SPEED
    told = reasons(values)
    assert {k for k, flags in enumerate(told) if flags} == {*range(1303, 1400), *range(2003, 2008)}
    assert set(told[1303:1330]) == set(told[2003:2008]) == {frozen}
    assert set(told[1330:1400]) == {frozen | STALE}


def test_whether_both_have_frozen_is_known_while_it_lasts() -> None:
    intake, values = Intake(SMALL), noisy(1500)
    for since, lost in ((None, False), (1500, True)):
        told = values if since is None else [values[-1]] * 100
        ticks(feed(told, since or 0), intake)
        assert intake.frozen.silent is lost
    ticks(feed(noisy(1), 1600), intake)
    assert not intake.frozen.silent


def test_both_may_repeat_themselves_at_rest_or_where_they_often_do_or_have_no_noise() -> None:
    turned = noisy(2000)
    assert not any(reasons([*turned, *[(0.0, 0.0)] * 3000, *turned[:50], *[(812.5, 0.0)] * 3000]))
    coarse = [(round(torque, -2), round(speed, 1)) for torque, speed in turned]
    assert not any(reasons([*coarse, *[coarse[-1]] * 500]))
    for ever in ({"torque_noise": 0.0}, {"speed_noise": 0.0}):
        assert not any(reasons([*turned, *[turned[-1]] * 500], **ever))


def test_a_channel_that_is_read_less_often_from_now_on_is_not_frozen_for_long() -> None:
    """Its first value so held is as that of one that has frozen; from the second on that is usual."""
    values = noisy(3000)
    held = [
        (values[k - k % 5][0], speed) if k >= 1500 else (torque, speed)
        for k, (torque, speed) in enumerate(values)
    ]
    assert [k for k, flags in enumerate(reasons(held)) if flags] == [1503, 1504]


def test_a_string_that_stands_may_have_readings_that_do() -> None:
    """A drive that is switched off tells no torque, and an encoder at rest no other angle."""
    turned, noise = noisy(1200), np.random.default_rng(4).standard_normal((300, 2))
    off = [(0.0, 0.1 + 0.015 * speed) for _, speed in noise]
    at_rest = [(80 * torque, 0.01) for torque, _ in noise]
    assert not any(reasons([*turned, *off, *turned[:5], *at_rest]))


def test_a_long_stand_before_the_start_is_not_what_is_usual() -> None:
    stands = [(0.0, 0.0)] * 3000
    moving = [(5e3 * math.sin(k / 7), 5 * math.sin(k / 10)) for k in range(1, 1001)]
    frozen = [(1234.5, speed) for _, speed in moving]
    told = reasons([*stands, *moving, *frozen])
    assert set(told[:4003]) == {Reason(0)}
    assert set(told[4003:]) == {Reason.FROZEN_TORQUE | Reason.STALE_TORQUE}


def test_where_both_stand_still_or_a_channel_is_without_noise_nothing_is_frozen() -> None:
    assert not any(reasons([(0.0, 0.0)] * 1000))
    noise = np.random.default_rng(1).normal(size=1000)
    assert not any(reasons([(0.0, 0.015 * each) for each in noise]))
    assert not any(reasons([(80 * each, 0.0) for each in noise]))
    stepped = [(7000.0, k / 100) for k in range(1000)]
    assert any(reasons(stepped))
    assert not any(reasons(stepped, torque_noise=0.0))


def test_a_silent_channel_is_stale_and_not_frozen() -> None:
    intake = Intake(SMALL)
    moving = [(T, Sample(time_ns=BEGUN + 10 * MS * k, value=float(50 * k))) for k in range(2000)]
    told = ticks([*one(S, steps(0, 1)), *moving], intake)
    assert {tick.reasons for tick in told[200:]} == {Reason.STALE_SPEED}


spells = st.lists(
    st.tuples(
        st.sampled_from(["live", "torque held", "speed held", "both held"]),
        st.sampled_from([0.0, 9.0, -9.0]),
        st.sampled_from([1, 2, 4, 9, 30]),
    ),
    max_size=12,
)


def through(told: list[tuple[str, float, int]]) -> list[tuple[float, float]]:
    """Readings of a string turned at some speed or not at all, of which one or both may be held."""
    readings = [(0.0, 0.0)]
    for what, speed, count in told:
        for _ in range(count):
            k, before = len(readings), readings[-1]
            readings.append((k * 37 % 101 * 50.0, speed + k * 17 % 53 / 1e3))
            if what in ("torque held", "both held"):
                readings[-1] = (before[0], readings[-1][1])
            if what in ("speed held", "both held"):
                readings[-1] = (readings[-1][0], before[1])
    return readings


@given(spells, st.sampled_from([3, 50, 10_000]), st.integers(0, 100), st.sampled_from([0.03, 0.4]))
def test_by_columns_and_gone_on_with_it_is_the_same(
    told: list[tuple[str, float, int]], cut: int, split: int, known_s: float
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stretch, "FEWEST", 4)
        for name, value in (
            ("LASTING_S", 0.1),
            ("KNOWN_S", known_s),
            ("SURELY_S", 0.03),
            ("SURELY_TICKS", 4),
        ):
            patch.setattr(f"vsensor.intake.frozen.{name}", value)
        for name, whole in (("UNUSUAL", 2), ("SELDOM", 3), ("MOST_RUNS", 9)):
            patch.setattr(f"vsensor.intake.frozen.{name}", whole)
        as_one_by_one(SMALL, feed(through(told)), cut, split)


def test_what_comes_of_a_frozen_torque_is_not_called_good() -> None:
    readings = simulated(20)
    begun, ended, since = (round(seconds * RATE) for seconds in (6, 12, 6 + LASTING_S))
    held = readings[begun].motor_torque
    frozen = [reading._replace(motor_torque=held) for reading in readings[begun:ended]]
    chunks = list(Offline(SHORT).estimates(samples([*readings[:begun], *frozen, *readings[ended:]])))
    quality = np.concatenate([chunk["quality"] for chunk in chunks])
    assert quality[begun] == quality[-1] == "good"
    assert set(quality[since + 1 : ended]) == {"uncertain"}


def test_the_other_must_move_by_more_than_its_noise() -> None:
    noise = SMALL.measurement.speed_noise
    nearly, beyond = ([(1.0, share * MOVED * noise * k / 999) for k in range(1000)] for share in (0.99, 1.01))
    assert not any(reasons(nearly))
    assert any(reasons(beyond))


@pytest.mark.parametrize("place", [1, 4, 8])
@pytest.mark.parametrize("count", [math.inf, 1e308, -1.0])
def test_a_damaged_count_of_ticks_is_refused(count: float, place: int) -> None:
    saved = Intake(SMALL).save()
    saved["frozen"][0][place] = count
    with pytest.raises(ValueError, match=rf"frozen\[0\]\[{place}\] holds .* where a whole number from 0"):
        Intake(SMALL).restore(json.loads(json.dumps(saved)))
