"""What is usual for a channel's changes: soon learned, never from what is wild, by columns as one by one."""

import json
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.rigs import BEGUN_NS, NS, RATE, SHORT, samples
from tests.strings import PIPE, rig
from tests.test_arrivals import as_one_by_one, by_columns_alone
from tests.test_intake import SMALL, S, T, both, reading, steps, ticks
from tests.test_intake_ahead import refused
from tests.test_intake_leaps import FAR, LEVEL, NOISE, Readings, noisy
from vsensor.intake import Intake, stretch
from vsensor.intake.leaps import BLOCK, OFTEN, Leaps
from vsensor.offline import Offline
from vsensor.simulate.rig import Reading, SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

Floats = NDArray[np.float64]


def toggling(rng: np.random.Generator) -> Floats:
    return np.where(rng.random(5000) < 0.5, 8.0, 9.0)


def seldom_toggling(rng: np.random.Generator) -> Floats:
    return np.where(rng.random(5000) < 0.2, 8.0, 9.0)


def alternating(_: np.random.Generator) -> Floats:
    return np.resize([8.0, 9.0], 5000)


def far_noisier(rng: np.random.Generator) -> Floats:
    return rng.normal(8.0, 1.0, 5000)


def sampled_slowly(rng: np.random.Generator) -> Floats:
    """Less than three samples a period: hardly two changes are alike."""
    swing: Floats = 8 + 4 * np.sin(2.3 * np.arange(5000))
    return rng.normal(swing, 0.015)


def read_in_steps(_: np.random.Generator) -> Floats:
    return np.repeat([8.0, 9.0, 10.0, 11.0, 9.0], 1000)


@pytest.mark.parametrize("configured", [0.0, 1e-6, 0.015])
@pytest.mark.parametrize(
    "of", [toggling, seldom_toggling, alternating, far_noisier, sampled_slowly, read_in_steps]
)
def test_what_is_usual_for_a_channel_is_soon_doubted_no_longer(
    of: Callable[[np.random.Generator], Floats], configured: float
) -> None:
    """However far it is beyond the configured noise: 20 samples at the most are refused, of the first 64, and
    from then on none. At 100 Hz that is 0.6 s."""
    values = of(np.random.default_rng(1))
    intake = Intake(rig(PIPE, measurement={"speed_noise": configured}))
    counts = intake.channels[S].counts
    for k, value in enumerate(values.tolist()):
        ticks([reading(T, k / 100), reading(S, k / 100, value)], intake)
        if k == BLOCK:
            begun = counts.strays
            assert begun <= 20
    assert counts.strays == begun


@settings(max_examples=40)
@given(st.lists(st.sampled_from([0.0, 0.01, 1.0, 1.1, 30.0]), max_size=400), st.integers(1, 200))
def test_no_more_than_one_in_eight_of_all_that_comes_is_refused_for_long(
    values: list[float], run: int
) -> None:
    """Whatever the signal: what leaps so often is usual. A run of `run` values over and over."""
    intake = Intake(SMALL)
    signal = (values * run)[:1500]
    ticks(
        [pair for k, v in enumerate(signal) for pair in (reading(T, k / 100), reading(S, k / 100, v))], intake
    )
    assert intake.channels[S].counts.strays <= (OFTEN + 1) / BLOCK * len(signal) + 20


def test_one_in_a_hundred_wild_does_not_make_the_wild_usual() -> None:
    fed = noisy(count=20_000)
    chance = np.random.default_rng(2)
    strays = 0
    for at in range(0, len(fed), 2):
        if chance.random() < 0.01:
            fed[at][1].value = float(chance.choice([-3e4, 3e4, 0.0]))
            strays += 1
    intake = Intake(SMALL)
    told = ticks(fed, intake)
    # Two in a row that agree bear each other out: one in some ten thousand.
    assert intake.channels[T].counts.strays >= 0.95 * strays
    assert np.mean([abs(tick.motor_torque - 8e3) > 2e3 for tick in told]) < 1e-3


@st.composite
def troubled(draw: st.DrawFn) -> Readings:
    """Both channels in order with all kinds of noise, steps, repeated and wild values."""
    chance = np.random.default_rng(draw(st.integers(0, 1 << 32)))
    fed: Readings = []
    for quiet, step, stray, count in draw(
        st.lists(
            st.tuples(
                st.sampled_from([0.0, 1e-3, 1.0, 100.0]),
                st.floats(-1, 1),
                st.sampled_from([0.0, 0.0, 0.01, 0.2]),
                st.integers(1, 200),
            ),
            max_size=6,
        )
    ):
        for topic_values in zip(
            *(_signal(chance, t, quiet, step, stray, count) for t in (T, S)), strict=True
        ):
            at_s = len(fed) / 200
            fed += [reading(topic, at_s, v) for topic, v in zip((T, S), topic_values, strict=True)]
    return fed


def _signal(
    chance: np.random.Generator, topic: str, quiet: float, step: float, stray: float, count: int
) -> Floats:
    values = LEVEL[topic] * (1 + step) + quiet * NOISE[topic] * chance.normal(size=count)
    values = np.where(chance.random(count) < stray, chance.normal(0, FAR[topic], count), values)
    return np.clip(values, -2 * FAR[topic], 2 * FAR[topic])


@settings(max_examples=40)
@given(troubled(), st.sampled_from([7, 50, 10_000]), st.sampled_from([2, 64]), st.integers(0, 500))
def test_by_columns_and_gone_on_with_it_is_the_same(fed: Readings, cut: int, fewest: int, split: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stretch, "FEWEST", fewest)
        as_one_by_one(SMALL, fed, cut, split)


changes = st.lists(st.sampled_from([0.0, 0.1, 0.2, 1.0, 7.0, 50.0]), max_size=300)


@given(changes, changes)
def test_what_is_usual_is_the_same_told_at_once(before: list[float], then: list[float]) -> None:
    one_way, other = Leaps(0.015, 60.0), Leaps(0.015, 60.0)
    for change in before:
        one_way.note(change)
    for change in then:
        one_way.note(change)
    other.note_all(np.array(before))
    other.note_all(np.array(then))
    assert other.save() == one_way.save()


@pytest.mark.parametrize("apart", [20_000, 100, 50])
def test_noise_as_configured_and_strays_in_it_go_by_columns(
    apart: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    fed = noisy(count=5000)
    for at in (*range(apart, len(fed), apart), *range(apart + 1, len(fed), apart)):
        fed[at][1].value *= -2
    intake = by_columns_alone(SMALL, fed, monkeypatch)
    for channel in intake.channels.values():
        assert channel.counts.strays == len(range(apart, len(fed), apart))


def test_a_state_of_a_version_that_doubted_no_value_is_taken_up() -> None:
    intake = Intake(SMALL)
    ticks(both(steps(0, 1)), intake)
    held = json.loads(json.dumps(intake.save()))
    for channel in held["channels"].values():
        del channel["leaps"]
    other = Intake(SMALL)
    other.restore(held)
    assert ticks(both(steps(1, 2)), other) == ticks(both(steps(1, 2)), intake)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("usual", -1.0, "leaps.usual holds -1.0 where a number from 0"),
        ("usual", 1e9, r"leaps.usual holds 1000000000.0 where a number from 0 to \d+"),
        ("count", 64, "leaps.count holds 64 where a whole number from 0 to 63"),
        ("largest", [0.0] * 6, r"leaps.largest holds .* where a list of 7"),
        ("largest", [1.0] + [0.0] * 6, r"leaps.largest holds .* in ascending order"),
        ("largest", [1.0] * 7, r"leaps.largest holds .* no more than 0 that are not 0"),
    ],
)
def test_a_damaged_one_is_refused_by_name(key: str, value: object, said: str) -> None:
    held = json.loads(json.dumps(Intake(SMALL).save()))
    held["channels"][S]["leaps"][key] = value
    with pytest.raises(ValueError, match=said):
        Intake(SMALL).restore(held)


def confirmed_error(readings: list[Reading], fed: list[Reading]) -> float:
    """Root mean square by which the confirmed bit speed of what was fed misses the truth of the readings."""
    told = [dict(chunk) for chunk in Offline(SHORT).estimates(samples(fed))]
    time_s, speed = (
        np.concatenate([chunk[name] for chunk in told]).astype(float)
        for name in ("confirmed_time_s", "confirmed_speed_rad_s")
    )
    time_s -= BEGUN_NS / NS
    truth_s, truth = np.array([(each.bit_time_s, each.bit_speed) for each in readings]).T
    known = np.isfinite(speed) & (time_s > 10) & (time_s < truth_s[-1])
    return float(np.sqrt(np.mean((speed[known] - np.interp(time_s[known], truth_s, truth)) ** 2)))


def test_with_one_in_a_hundred_torques_wild_confirmed_is_as_good_as_without(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    source, chance = SimulatedRig(SHORT, PLANS[Scenario.STICK_SLIP], 1), np.random.default_rng(3)
    clean = [source.sample() for _ in range(40 * RATE)]
    dirty = [
        each._replace(motor_torque=float(chance.choice([-3e4, 3e4]))) if chance.random() < 0.01 else each
        for each in clean
    ]
    assert sum(a != b for a, b in zip(clean, dirty, strict=True)) >= 10
    error = confirmed_error(clean, clean)
    assert confirmed_error(clean, dirty) < 1.1 * error
    monkeypatch.setattr(Leaps, "is_one", lambda *_: False)
    assert confirmed_error(clean, dirty) > 2 * error


def test_one_in_eleven_wild_is_refused_to_the_last() -> None:
    """Each counts as one change, for none is taken from a stray: the way there and back would be two."""
    fed = noisy(count=10 * BLOCK)
    for at in range(22, len(fed), 22):
        fed[at][1].value = 3e4
    intake = Intake(SMALL)
    ticks(fed, intake)
    assert refused(intake, T) == {"strays": len(range(22, len(fed), 22))}
