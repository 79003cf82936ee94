"""The estimator as a whole: exact, however it is fed, and honest about what it does not know."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.strings import BIT, COLLAR, DRIVE, PIPE, rig
from vsensor.config import Component, Rig
from vsensor.estimator.estimator import Estimates, Estimator
from vsensor.estimator.kernel import CONFIRMED, FORECAST, NOW, SPEED, SPEED_STD, STICK, TORQUE, TORQUE_STD
from vsensor.estimator.score import MEMORY_S
from vsensor.estimator.sections import Floats
from vsensor.quality import Quality, Reason, verdict
from vsensor.simulate.rig import Reading, SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

DRILLING = rig(
    PIPE.model_copy(update={"length": 2500.0}),
    COLLAR,
    bit=BIT,
    top_drive=DRIVE,
)
LINEAR = rig(PIPE.model_copy(update={"coulomb_friction": 0.0, "static_friction": 0.0}), COLLAR, rate=50.0)
ANYTHING = st.floats(allow_nan=True, allow_infinity=True)


def record(of: Rig, scenario: Scenario, seconds: float) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Readings of a simulated rig, one a row, columns as in `Reading`."""
    simulated = SimulatedRig(of, PLANS[scenario], seed=7)
    return np.array([simulated.sample() for _ in range(round(seconds * of.loop.rate))])


STUCK = record(DRILLING, Scenario.STICK_SLIP, 40.0)


def column(name: str) -> Floats:
    return np.asarray(STUCK[:, Reading._fields.index(name)])


def same(one: Estimates, other: Estimates) -> bool:
    return one.values.tobytes() == other.values.tobytes() and bool((one.reasons == other.reasons).all())


def converged(one: Estimates, other: Estimates, since: int) -> bool:
    """Whether confirmed answers differ by no more than is stated, in the mean of the squares.

    Not to the bit: rock, law and configuration were learned from other samples.
    """
    for value, deviation in ((SPEED, SPEED_STD), (TORQUE, TORQUE_STD)):
        apart = one.values[since:, CONFIRMED + value] - other.values[since:, CONFIRMED + value]
        stated = other.values[since:, CONFIRMED + deviation]
        if not np.mean(apart**2) < np.mean(stated**2):
            return False
    return len(one.values) > since


@pytest.fixture(scope="module")
def estimator() -> Estimator:
    return Estimator(DRILLING)


@pytest.fixture(scope="module")
def answers(estimator: Estimator) -> Estimates:
    estimator.reset()
    return estimator.run(column("motor_torque"), column("motor_speed"))


@settings(max_examples=15, deadline=None)
@given(st.lists(st.integers(0, 900), max_size=12))
def test_any_split_of_the_input_gives_the_same_bits(cuts: list[int]) -> None:
    torque, speed = column("motor_torque")[:900], column("motor_speed")[:900]
    at_once = Estimator(DRILLING).run(torque, speed)
    estimator = Estimator(DRILLING)
    parts = [
        estimator.run(t, w)
        for t, w in zip(np.split(torque, sorted(cuts)), np.split(speed, sorted(cuts)), strict=True)
    ]
    values = np.concatenate([part.values for part in parts])
    assert same(at_once, Estimates(values, np.concatenate([part.reasons for part in parts]), at_once.delays))


def test_a_step_is_a_run_of_one(estimator: Estimator, answers: Estimates) -> None:
    estimator.reset()
    for k in range(600):
        values, reasons = estimator.step(column("motor_torque")[k], column("motor_speed")[k])
        assert values.tobytes() == answers.values[k].tobytes()
        assert reasons == answers.reasons[k]


def test_reset_forgets_all(estimator: Estimator, answers: Estimates) -> None:
    estimator.run([9e3, math.nan, -4e4], [3.0, 2.0, math.inf])
    estimator.reset()
    assert same(answers, estimator.run(column("motor_torque"), column("motor_speed")))


def test_a_rig_that_turns_the_other_way_is_told_to_the_same_bits(
    estimator: Estimator, answers: Estimates
) -> None:
    estimator.reset()
    other = estimator.run(-column("motor_torque"), -column("motor_speed"))
    sign = np.tile([-1.0, 1.0], 8)
    np.testing.assert_array_equal(other.values[:, :16], sign * answers.values[:, :16])
    assert other.reasons.tobytes() == answers.reasons.tobytes()


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(ANYTHING, ANYTHING), min_size=1, max_size=300), st.booleans())
def test_garbage_in_never_gives_nan_out_as_good(given_: list[tuple[float, float]], long: bool) -> None:
    torque, speed = np.array(given_ * (4 if long else 1)).T
    out = Estimator(LINEAR).run(torque, speed)
    for values, reasons in zip(out.values, out.reasons, strict=True):
        if verdict(Reason(int(reasons))) is Quality.GOOD:
            assert np.isfinite(values[CONFIRMED : CONFIRMED + 4]).all()


def test_a_missing_input_is_flagged_for_as_long_as_it_takes_part(
    estimator: Estimator, answers: Estimates
) -> None:
    torque = column("motor_torque").copy()
    torque[1500] = math.nan
    estimator.reset()
    out = estimator.run(torque, column("motor_speed"))
    flagged = np.flatnonzero(out.reasons & int(Reason.STALE_TORQUE))
    assert flagged[0] == 1500
    assert len(flagged) == round(estimator.warm_up * DRILLING.loop.rate)
    assert out.values[:1500].tobytes() == answers.values[:1500].tobytes()
    assert converged(out, answers, int(flagged[-1]) + 1)


def test_nothing_is_told_before_all_waves_of_an_answer_were_seen(
    estimator: Estimator, answers: Estimates
) -> None:
    warm = round(estimator.warm_up * DRILLING.loop.rate)
    assert np.isnan(answers.values[:warm]).all()
    assert all(Reason(int(r)) & Reason.WARMING_UP for r in answers.reasons[:warm])
    assert np.isfinite(answers.values[warm, CONFIRMED : CONFIRMED + 4]).all()
    # and no prediction before one has been scored, for its deviation is not known
    scored = np.flatnonzero(np.isfinite(answers.values[:, NOW]))[0]
    assert scored == pytest.approx(warm + estimator.confirmed_delay * DRILLING.loop.rate, abs=1.5)


@pytest.mark.parametrize(
    ("kind", "speed_limit", "torque_limit"), [(CONFIRMED, 0.25, 600), (NOW, 0.9, 700), (FORECAST, 1.1, 850)]
)
def test_the_bit_is_found(
    estimator: Estimator, answers: Estimates, kind: int, speed_limit: float, torque_limit: float
) -> None:
    """Against the simulated truth, its string cut and stepped more finely; the bit turns 0 to 30 rad/s."""
    shift = {CONFIRMED: -estimator.confirmed_delay, NOW: 0.0, FORECAST: estimator.forecast_horizon}[kind]
    told = np.isfinite(answers.values[:, kind]) & (column("time_s") + shift < column("bit_time_s")[-1])
    when = (column("time_s") + shift)[told]
    truth = np.interp(when, column("bit_time_s"), column("bit_speed"))
    assert np.ptp(truth) > 20
    error = answers.values[told, kind + SPEED] - truth
    assert np.sqrt(np.mean(error**2)) < speed_limit
    torque = np.interp(when, column("bit_time_s"), column("bit_torque"))
    assert np.sqrt(np.mean((answers.values[told, kind + TORQUE] - torque) ** 2)) < torque_limit
    assert abs(np.mean(answers.values[told, kind + TORQUE] - torque)) < 100


def test_the_running_error_of_each_horizon_is_that_of_the_answers(estimator: Estimator) -> None:
    """Now and forecast held against the confirmed answers for the same times, what is older forgotten."""
    estimator.reset()
    answers = estimator.run(column("motor_torque"), column("motor_speed"))
    rate, skill = DRILLING.loop.rate, estimator.skill
    np.testing.assert_allclose(
        skill[:, 0], np.linspace(0, estimator.forecast_horizon, len(skill)), atol=1 / rate
    )
    ticks = np.arange(len(answers.values))
    confirmed_for = ticks / rate - estimator.confirmed_delay
    for row, kind in ((0, NOW), (-1, FORECAST)):
        when = ticks / rate + skill[row, 0]
        came = np.isfinite(answers.values[:, kind]) & (when < confirmed_for[-1])
        weight = np.exp((when[came] - when[came][-1]) / MEMORY_S)
        for column_of_skill, quantity in ((1, SPEED), (2, TORQUE)):
            truth = np.interp(when[came], confirmed_for, answers.values[:, CONFIRMED + quantity])
            miss = answers.values[came, kind + quantity] - truth
            expected = np.sqrt((weight * miss**2).sum() / weight.sum())
            assert skill[row, column_of_skill] == pytest.approx(expected, rel=0.1)
    assert skill[0, 1] < skill[-1, 1]


def test_no_skill_is_told_before_a_prediction_came_true() -> None:
    assert np.isnan(Estimator(LINEAR).skill[:, 1:]).all()


def test_a_string_shorter_than_the_smoothers_lag_is_told_up_to_now_and_a_little_ahead() -> None:
    lab = rig(COLLAR.model_copy(update={"length": 30.0}), bit={"inertia": 1.0, "viscous_friction": 10.0})
    estimator = Estimator(lab)
    assert 0 < estimator.forecast_horizon < 0.02
    out = estimator.run(np.full(300, 50.0), np.full(300, 5.0))
    assert verdict(Reason(int(out.reasons[-1]))) is Quality.GOOD
    assert out.values[-1, CONFIRMED + SPEED] == pytest.approx(5.0, abs=1e-4)
    for kind in (NOW, FORECAST):
        assert out.values[-1, kind + SPEED] == pytest.approx(5.0, abs=0.01)


def test_inputs_of_unequal_length_are_refused() -> None:
    with pytest.raises(ValueError, match="3 torques, 2 speeds and 3 reasons"):
        Estimator(LINEAR).run([1, 2, 3], [1, 2])


@pytest.mark.parametrize("channel", ["motor_torque", "motor_speed"])
def test_one_channel_lost_is_bridged_by_the_load_law_and_its_return_is_seamless(
    estimator: Estimator, answers: Estimates, channel: str
) -> None:
    """Ten seconds of stick-slip without one of the channels, then both again."""
    inputs = {name: column(name).copy() for name in ("motor_torque", "motor_speed")}
    lost = slice(2000, 3000)
    inputs[channel][lost] = math.nan
    estimator.reset()
    out = estimator.run(inputs["motor_torque"], inputs["motor_speed"])
    truth = np.interp(column("time_s") - estimator.confirmed_delay, column("bit_time_s"), column("bit_speed"))
    # All of it told, graded uncertain, with a wider deviation than before, and true within it
    told = out.values[lost, CONFIRMED : CONFIRMED + 4]
    assert np.isfinite(told).all()
    assert {verdict(Reason(int(r))) for r in out.reasons[lost]} == {Quality.UNCERTAIN}
    measured = answers.values[lost, CONFIRMED + SPEED_STD]
    assert (told[:, SPEED_STD] >= measured).mean() > 0.9
    assert told[:, SPEED_STD].mean() > 2 * measured.mean()
    error = told[:, SPEED] - truth[lost]
    assert np.ptp(truth[lost]) > 20
    assert np.sqrt(np.mean(error**2)) < 3.0
    assert np.mean(np.abs(error) <= 2 * told[:, SPEED_STD]) > 0.8
    # Once all waves of the answer were measured again it is as near to the truth as if nothing had been.
    after = slice(3000 + round(estimator.warm_up * 100), None)
    missed, unhurt = ((of.values[after, CONFIRMED + SPEED] - truth[after]) for of in (out, answers))
    assert np.sqrt(np.mean(missed**2)) < 1.5 * np.sqrt(np.mean(unhurt**2))
    assert {verdict(Reason(int(r))) for r in out.reasons[after]} == {Quality.GOOD}


def test_a_saved_state_goes_on_to_the_same_bits(estimator: Estimator, answers: Estimates) -> None:
    estimator.reset()
    estimator.run(column("motor_torque")[:2500], column("motor_speed")[:2500])
    saved = estimator.save()
    other = Estimator(DRILLING)
    estimator.run([1e4] * 50, [9.0] * 50)  # what is saved is a copy
    other.restore(saved)
    out = other.run(column("motor_torque")[2500:], column("motor_speed")[2500:])
    assert same(out, Estimates(answers.values[2500:], answers.reasons[2500:], out.delays))


def test_a_state_of_another_string_is_refused() -> None:
    with pytest.raises(ValueError, match=r"saved state: \w+ is float64"):
        Estimator(DRILLING).restore(Estimator(rig(PIPE, COLLAR)).save())
    with pytest.raises(ValueError, match="the saved state lacks ahead, "):
        Estimator(DRILLING).restore({"waves": np.zeros(3)})


def test_a_restart_keeps_what_was_learned_and_forgets_the_waves(
    estimator: Estimator, answers: Estimates
) -> None:
    estimator.reset()
    estimator.run(column("motor_torque"), column("motor_speed"))
    learned = estimator.save()["learned.law"]
    estimator.restart()
    assert estimator.save()["learned.law"].tolist() == learned.tolist()
    out = estimator.run(column("motor_torque"), column("motor_speed"))
    assert converged(out, answers, 2000)
    warm = round(estimator.warm_up * DRILLING.loop.rate)
    assert np.isfinite(out.values[warm, NOW : NOW + 4]).all()  # its error is known from before


def test_a_source_that_is_never_more_than_uncertain_is_told_of_now_all_the_same(
    estimator: Estimator, answers: Estimates
) -> None:
    estimator.reset()
    always = np.full(len(STUCK), int(Reason.SOURCE_UNCERTAIN))
    out = estimator.run(column("motor_torque"), column("motor_speed"), always)
    told = np.isfinite(answers.values[:, :STICK])
    assert np.isfinite(out.values[:, :STICK][told]).all()
    assert {verdict(Reason(int(r))) for r in out.reasons[told.any(axis=1)]} == {Quality.UNCERTAIN}


def test_the_forecast_reaches_as_far_as_asked_and_no_further_than_the_waves() -> None:
    full = Estimator(DRILLING).forecast_horizon
    for asked, reached in ((0.3, 0.3), (99.0, full)):
        some = DRILLING.model_copy(
            update={"estimator": DRILLING.estimator.model_copy(update={"horizon": asked})}
        )
        assert Estimator(some).forecast_horizon == pytest.approx(reached, abs=0.005)


def test_while_the_wall_rests_the_torque_below_it_is_only_bounded() -> None:
    """A string wound up and held: its wall may bear any share of the torque up to its static friction."""
    rough = PIPE.model_copy(update={"coulomb_friction": 2.0, "static_friction": 3.0})
    bit = {"inertia": 50.0, "kinetic_torque": 9e3}
    held = Estimator(rig(rough, COLLAR, bit=bit, top_drive=DRIVE))
    told = held.run(np.full(1500, 2e3), np.zeros(1500)).values[-1]
    assert told[CONFIRMED + TORQUE_STD] == pytest.approx(1500 * 3.0 / math.sqrt(3), rel=0.05)


def test_behind_a_gear_the_string_is_the_same(answers: Estimates) -> None:
    """A motor that turns eight times as fast, and loses a tenth of its torque in the gear."""
    turns, efficiency = 8.0, 0.9
    noise = DRILLING.measurement
    geared = rig(
        *DRILLING.string,
        bit=BIT,
        top_drive={**DRIVE, "gear_ratio": turns, "efficiency": efficiency},
        measurement={
            "torque_noise": noise.torque_noise / turns / efficiency,
            "speed_noise": noise.speed_noise * turns,
        },
    )
    out = Estimator(geared).run(column("motor_torque") / turns / efficiency, column("motor_speed") * turns)
    np.testing.assert_array_equal(np.isnan(out.values), np.isnan(answers.values))
    told = out.values[:2000, CONFIRMED + SPEED]
    np.testing.assert_allclose(told, answers.values[:2000, CONFIRMED + SPEED], atol=1e-6)


def test_a_rod_in_a_laboratory_is_told_as_a_well_is() -> None:
    """30 m of 10 mm, and a brake of some newton metres: what is restless there is far less than any rock."""
    rod = Component(length=30.0, outer_diameter=0.01, inner_diameter=0.0, viscous_friction=2e-4)
    brake = {"inertia": 0.3, "viscous_friction": 0.05, "kinetic_torque": 4.0, "static_torque": 9.0}
    noise = {"torque_noise": 0.1, "speed_noise": 0.01}
    of = rig(rod, rate=500.0, bit=brake, top_drive={"inertia": 2.0}, measurement=noise)
    readings = record(of, Scenario.STICK_SLIP, 30.0)
    estimator = Estimator(of)
    told = estimator.run(readings[:, 1], readings[:, 2]).values
    seen, bit = slice(5000, None), Reading._fields.index("bit_speed")
    late = np.interp(readings[:, 0] - estimator.confirmed_delay, readings[:, 3], readings[:, bit])
    swing = np.ptp(readings[seen, bit])
    assert np.std((told[:, CONFIRMED] - late)[seen]) < 0.03 * swing
    assert np.std((told[:, NOW] - readings[:, bit])[seen]) < 0.1 * swing
    assert estimator.rock_std < 2.0
