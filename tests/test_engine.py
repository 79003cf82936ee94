"""One engine: the same answers live, offline, from recorded ticks and straight from the estimator."""

import math
from collections.abc import Iterable

import numpy as np
import pytest

from tests.rigs import BEGUN_NS, NS, RATE, SHORT, Surface, samples, simulated
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.figures import BIT_SPEED, BIT_TORQUE, TOP_SPEED, TOP_TORQUE
from vsensor.estimator.severity import severity
from vsensor.estimator.tune import DELAY
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Estimate, Sample, Tick
from vsensor.offline import Offline
from vsensor.quality import Quality, Reason
from vsensor.service.engine import Engine
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario
from vsensor.tables import ESTIMATE_FIELDS

Taken = list[tuple[Tick, Estimate]]
SECONDS = 12.0


def take(engine: Engine, feed: Iterable[tuple[str, Sample | None]]) -> Taken:
    return [answer for topic, sample in feed for answer in engine.take(topic, sample)]


def untidy(feed: Surface) -> Surface:
    """As a network delivers it: some lost, some doubled, some swapped, one of no use."""
    mixed: Surface = []
    for number, (topic, sample) in enumerate(feed):
        if number % 97 == 0 or 400 <= number < 440:
            continue
        mixed.append((topic, sample))
        if number % 31 == 0:
            mixed.append((topic, sample))
        if number % 53 == 0 and len(mixed) > 4:
            mixed[-1], mixed[-3] = mixed[-3], mixed[-1]
        if number % 89 == 0:
            mixed.append((topic, Sample(time_ns=sample.time_ns + 1, value=math.nan)))
    return mixed


@pytest.fixture(scope="module")
def feed() -> Surface:
    return untidy(samples(simulated(SECONDS)))


@pytest.fixture(scope="module")
def taken(feed: Surface) -> Taken:
    return take(Engine(SHORT), feed)


def same_to_the_bit(one: Iterable[Estimate], other: Iterable[Estimate]) -> bool:
    return [e.SerializeToString() for e in one] == [e.SerializeToString() for e in other]


def test_it_answers_each_tick_once(taken: Taken) -> None:
    assert len(taken) == pytest.approx(SECONDS * RATE, abs=2)
    assert [tick.number for tick, _ in taken] == list(range(len(taken)))
    assert all((e.number, e.time_ns) == (t.number, t.time_ns) for t, e in taken)


def test_offline_gives_the_same_to_the_bit(feed: Surface, taken: Taken) -> None:
    chunks = list(Offline(SHORT).estimates(feed))
    columns = {name: np.concatenate([chunk[name] for chunk in chunks]) for name in ESTIMATE_FIELDS}
    assert len(columns["time_s"]) == len(taken)
    for name, field in ESTIMATE_FIELDS.items():
        if name == "quality":
            told = [Quality(estimate.quality).name.lower() for _, estimate in taken]
            assert columns[name].tolist() == told
            continue
        scale = NS if field.endswith("_ns") else 1
        live = [getattr(e, field) / scale if e.HasField(field) else math.nan for _, e in taken]  # type: ignore[arg-type]
        assert columns[name].tobytes() == np.array(live).tobytes(), name


def test_the_estimator_alone_gives_the_same_to_the_bit(taken: Taken) -> None:
    ticks = [tick for tick, _ in taken]
    values, reasons, _ = Estimator(SHORT).run(
        [tick.motor_torque_nm for tick in ticks],
        [tick.motor_speed_rad_s for tick in ticks],
        [tick.reasons for tick in ticks],
    )
    assert [estimate.reasons for _, estimate in taken] == reasons.tolist()
    for field, column in (("confirmed_bit_speed_rad_s", 0), ("now_bit_torque_nm", 6)):
        live = [getattr(e, field) if e.HasField(field) else math.nan for _, e in taken]  # type: ignore[arg-type]
        assert values[:, column].tobytes() == np.array(live).tobytes()


def test_ticks_read_back_from_a_recording_give_the_same_to_the_bit(taken: Taken) -> None:
    stored = [Tick.FromString(tick.SerializeToString()) for tick, _ in taken]
    assert same_to_the_bit(map(Engine(SHORT).step, stored), [estimate for _, estimate in taken])


def test_a_clock_that_was_set_begins_anew_but_what_was_learned_stays() -> None:
    readings = simulated(SECONDS)
    engine = Engine(SHORT)
    take(engine, samples(readings[:300]))
    again = take(engine, samples(readings[299:], BEGUN_NS + 3600 * NS, sequence=300))

    assert engine.intake.restarts == 1
    fresh = take(Engine(SHORT), samples(readings[300:], BEGUN_NS + 3600 * NS))
    grades, expected = (
        [(e.number, e.time_ns, e.quality, e.reasons, e.confirmed_time_ns) for _, e in taken]
        for taken in (again, fresh)
    )
    assert grades == expected
    # The waves are those of the new samples alone; gains and law are better known than at first.
    first = next(number for number, (_, estimate) in enumerate(again) if not estimate.reasons)
    for (_, one), (_, other) in list(zip(again, fresh, strict=True))[first:]:
        apart = one.confirmed_bit_speed_rad_s - other.confirmed_bit_speed_rad_s
        assert abs(apart) < other.confirmed_bit_speed_std_rad_s
    assert again[first][1].HasField("now_bit_speed_rad_s")  # its own error is known from before
    assert not fresh[first][1].HasField("now_bit_speed_rad_s")


def test_answers_are_timed_by_the_delay_as_corrected() -> None:
    """A string that is stiffer than configured; live as offline."""
    soft = SHORT.string[0].model_copy(update={"shear_modulus": 0.96 * SHORT.string[0].shear_modulus})
    source = SimulatedRig(SHORT, PLANS[Scenario.STICK_SLIP], 1)
    feed = samples([source.sample() for _ in range(120 * RATE)])
    wrong = SHORT.model_copy(
        update={"string": (soft,), "estimator": SHORT.estimator.model_copy(update={"learn": False})}
    )
    engine = Engine(wrong)
    configured = round(engine.estimator.confirmed_delay * NS)
    told = [estimate for _, estimate in take(engine, feed) if estimate.HasField("confirmed_bit_speed_rad_s")]
    delays = [estimate.time_ns - estimate.confirmed_time_ns for estimate in told]
    assert engine.estimator.tuning[DELAY] < 0
    assert delays[0] == configured
    assert delays[-1] == round(engine.estimator.confirmed_delay * NS) < configured
    columns = list(Offline(wrong).estimates(feed))
    offline = np.concatenate([chunk["confirmed_time_s"] for chunk in columns]).astype(float)
    live = [estimate.confirmed_time_ns / NS for estimate in told]
    assert offline[np.isfinite(offline)].tolist() == live


def test_warming_up_is_told_and_nothing_else_with_it(taken: Taken) -> None:
    warm_up = Estimator(SHORT).warm_up
    cold = [estimate for _, estimate in taken if estimate.reasons & Reason.WARMING_UP]
    assert len(cold) == round(warm_up * RATE)
    for estimate in cold:
        told = [field.name for field, _ in estimate.ListFields()]
        assert told == ["number", "time_ns", "quality", "reasons"]
        assert Quality(estimate.quality) is Quality.BAD


def test_no_number_without_its_deviation_time_and_quality(taken: Taken) -> None:
    for _, estimate in taken:
        assert estimate.HasField("quality")
        assert estimate.HasField("reasons")
        for kind in ("confirmed", "now", "forecast"):
            for what in ("speed{}_rad_s", "torque{}_nm"):
                value, deviation = (f"{kind}_bit_{what.format(tail)}" for tail in ("", "_std"))
                assert estimate.HasField(value) == estimate.HasField(deviation)  # type: ignore[arg-type]
            if kind != "now":
                known = estimate.HasField(f"{kind}_bit_speed_rad_s")  # type: ignore[arg-type]
                assert estimate.HasField(f"{kind}_time_ns") == known  # type: ignore[arg-type]


def test_the_three_answers_are_for_their_three_times(taken: Taken) -> None:
    estimator = Estimator(SHORT)
    last = taken[-1][1]
    assert last.time_ns - last.confirmed_time_ns == round(estimator.confirmed_delay * NS)
    assert last.forecast_time_ns - last.time_ns == round(estimator.forecast_horizon * NS)


def test_confirmed_is_near_the_truth_at_its_own_time() -> None:
    readings = simulated(SECONDS)
    answers = [e for _, e in take(Engine(SHORT), samples(readings)) if e.HasField("confirmed_time_ns")]
    times = np.array([(estimate.confirmed_time_ns - BEGUN_NS) / NS for estimate in answers])
    told = np.array([estimate.confirmed_bit_speed_rad_s for estimate in answers])
    true = np.interp(times, [r.bit_time_s for r in readings], [r.bit_speed for r in readings])
    turning = (times > 2) & (true > 1)
    assert np.sqrt(np.mean((told - true)[turning] ** 2)) < 0.5
    assert true[turning].max() > 10


def test_severity_is_that_of_the_window_and_forgets_at_a_restart(taken: Taken) -> None:
    engine = Engine(SHORT)
    for tick, _ in taken:
        engine.step(tick)
    window = [estimate.confirmed_bit_speed_rad_s for _, estimate in taken[-4 * RATE :]]
    assert severity(engine.window[BIT_SPEED]) == pytest.approx(severity(np.array(window)), rel=1e-12)

    engine.step(taken[0][0])
    assert np.isnan(engine.window).all()


@pytest.mark.parametrize(("rate", "apart"), [(40.0, 1), (150.0, 1), (250.0, 2), (400.0, 4)])
def test_the_window_is_as_long_at_any_rate_and_no_finer_than_the_bit_may_need(
    rate: float, apart: int
) -> None:
    engine = Engine(SHORT.model_copy(update={"loop": SHORT.loop.model_copy(update={"rate": rate})}))
    count = round(6 * rate)
    ticks = (Tick(number=k, motor_torque_nm=5e3, motor_speed_rad_s=math.sin(k / rate)) for k in range(count))
    told = [engine.step(tick).confirmed_bit_speed_rad_s for tick in ticks][::apart]
    length = round(SHORT.estimator.severity_window * rate / apart)
    assert engine.recent_s == pytest.approx(apart / rate)
    assert engine.window[BIT_SPEED].tolist() == told[-length:]


def test_the_window_has_top_and_bit_at_one_time(taken: Taken) -> None:
    """Oldest first; the string's top is what the surface measured, the top drive's inertia taken off."""
    readings = simulated(SECONDS)
    engine = Engine(SHORT)
    answers = [e for _, e in take(engine, samples(readings)) if e.HasField("confirmed_time_ns")]
    window = engine.window
    told = answers[-window.shape[1] :]
    assert window[BIT_SPEED].tolist() == [e.confirmed_bit_speed_rad_s for e in told]
    assert window[BIT_TORQUE].tolist() == [e.confirmed_bit_torque_nm for e in told]
    times = [(e.confirmed_time_ns - BEGUN_NS) / NS for e in told]
    speed = np.interp(times, [r.time_s for r in readings], [r.motor_speed for r in readings])
    np.testing.assert_allclose(window[TOP_SPEED], speed, atol=0.1)
    torque = np.interp(times, [r.time_s for r in readings], [r.motor_torque for r in readings])
    accelerates = SHORT.top_drive.inertia * np.gradient(window[TOP_SPEED], 1 / RATE)
    np.testing.assert_allclose(window[TOP_TORQUE], torque - accelerates, atol=500)


def test_it_is_warm_once_there_is_an_answer(taken: Taken) -> None:
    engine = Engine(SHORT)
    assert not engine.warm
    for tick, estimate in taken:
        engine.step(tick)
        assert engine.warm == estimate.HasField("confirmed_bit_speed_rad_s")


def test_an_unreadable_sample_is_counted_and_makes_no_tick() -> None:
    engine = Engine(SHORT)
    assert take(engine, [(SURFACE_TORQUE, None), (SURFACE_SPEED, None)]) == []
    assert engine.intake.channels[SURFACE_TORQUE].counts.unreadable == 1
