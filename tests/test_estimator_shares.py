"""Where ticks come faster than the bit is foretold, a march ahead is spread over several of them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.strings import BIT, COLLAR, DRIVE, PIPE, rig
from tests.test_estimator import record, same
from vsensor.estimator.ahead import REFRESH_HZ, WORTH, read_beyond, shares_of
from vsensor.estimator.estimator import Estimates, Estimator
from vsensor.estimator.kernel import FORECAST, NO_FORECAST, NOW, SPEED, STICK, TORQUE
from vsensor.estimator.sections import Floats
from vsensor.jit import COMPILED
from vsensor.simulate.rig import Reading
from vsensor.simulate.scenario import Scenario

if not COMPILED:
    pytest.skip("minutes of a rig: too slow without the compiler", allow_module_level=True)

SHARES = 4
RATE = SHARES * REFRESH_HZ
FAST = rig(PIPE, COLLAR, bit=BIT, top_drive=DRIVE, rate=RATE)
STUCK = record(FAST, Scenario.STICK_SLIP, 20.0)
TORQUES, SPEEDS = np.ascontiguousarray(STUCK[:, 1]), np.ascontiguousarray(STUCK[:, 2])
SINCE = round(10 * RATE)
"""The law is learned by then, and predictions were scored."""


def at_each_tick(estimator: Estimator) -> Estimator:
    """The same estimator, but with a whole march at each tick."""
    estimator._configured = estimator._configured._replace(shares=1)
    estimator._run_by(estimator._model._replace(shares=1))
    estimator._told = estimator._model
    return estimator


@given(st.floats(1, 5e3), st.floats(0, 2e4))
def test_what_is_read_of_a_march_was_known_when_it_set_out_but_for_little(rate: float, ticks: float) -> None:
    """On a short string, such as a laboratory's, each tick makes its own."""
    shares = shares_of(rate, ticks)
    assert shares >= 1
    assert read_beyond(shares, 1) <= WORTH * ticks
    assert shares == 1 or rate / shares >= REFRESH_HZ


def test_only_where_ticks_are_many_a_march_is_spread() -> None:
    assert [shares_of(rate, 1.8 * rate) for rate in (100.0, 199.0, 200.0, 1000.0)] == [1, 1, 2, 10]
    assert shares_of(1000.0, 75.0) == 1


@pytest.fixture(scope="module")
def estimator() -> Estimator:
    return Estimator(FAST)


@pytest.fixture(scope="module")
def spread(estimator: Estimator) -> Estimates:
    estimator.reset()
    return estimator.run(TORQUES, SPEEDS)


@pytest.fixture(scope="module")
def whole() -> Estimates:
    return at_each_tick(Estimator(FAST)).run(TORQUES, SPEEDS)


def miss(answers: Estimates, kind: int, quantity: int, truth: str) -> float:
    """Root mean square of what an answer misses the truth by."""
    time_s, bit_time_s = STUCK[:, 0], STUCK[:, Reading._fields.index("bit_time_s")]
    at_s = time_s + (answers.delays[1] if kind == FORECAST else 0.0)
    seen = (at_s < bit_time_s[-1]) & (np.arange(len(at_s)) >= SINCE)
    true: Floats = np.interp(at_s[seen], bit_time_s, STUCK[:, Reading._fields.index(truth)])
    return float(np.sqrt(np.mean((answers.values[seen, kind + quantity] - true) ** 2)))


@pytest.mark.parametrize("kind", [NOW, FORECAST])
@pytest.mark.parametrize(("quantity", "truth"), [(SPEED, "bit_speed"), (TORQUE, "bit_torque")])
def test_spread_it_misses_the_truth_by_little_more(
    spread: Estimates, whole: Estimates, kind: int, quantity: int, truth: str
) -> None:
    assert spread.values[SINCE:].tobytes() != whole.values[SINCE:].tobytes()
    assert miss(spread, kind, quantity, truth) < 1.1 * miss(whole, kind, quantity, truth)


def test_spread_it_foretells_the_same_sticks(spread: Estimates, whole: Estimates) -> None:
    ours, theirs = (np.isfinite(answers.values[SINCE:, STICK]) for answers in (spread, whole))
    assert theirs.any()
    assert not theirs.all()
    assert np.mean(ours != theirs) < 0.01


@pytest.mark.parametrize("cut", [1, SHARES - 1, SHARES])
def test_saved_in_the_middle_of_a_march_it_goes_on_to_the_same_bits(
    estimator: Estimator, spread: Estimates, cut: int
) -> None:
    estimator.reset()
    estimator.run(TORQUES[: SINCE + cut], SPEEDS[: SINCE + cut])
    saved = estimator.save()
    estimator.reset()
    estimator.restore(saved)
    rest = slice(SINCE + cut, SINCE + 3 * round(RATE))
    went_on = estimator.run(TORQUES[rest], SPEEDS[rest])
    assert same(went_on, Estimates(spread.values[rest], spread.reasons[rest], spread.delays[:, rest]))


@pytest.mark.parametrize("since", [0, 1])
def test_after_time_was_short_all_is_foretold_again_at_once(
    estimator: Estimator, whole: Estimates, since: int
) -> None:
    flags = np.zeros(len(TORQUES), np.uint32)
    back = SINCE + round(RATE) + since
    flags[SINCE:back] = NO_FORECAST
    estimator.reset()
    told = estimator.run(TORQUES, SPEEDS, flags).values[:, FORECAST + SPEED]
    assert np.isnan(told[SINCE:back]).all()
    assert np.isfinite(told[back:]).all()
    swing = np.ptp(whole.values[SINCE:, FORECAST + SPEED])
    assert abs(told[back] - whole.values[back, FORECAST + SPEED]) < 0.02 * swing


def test_a_string_made_longer_is_marched_along_at_once() -> None:
    answers: list[Floats] = []
    for estimator in (Estimator(FAST), at_each_tick(Estimator(FAST))):
        estimator.run(TORQUES[: SINCE + 1], SPEEDS[: SINCE + 1])
        estimator.lengthen(28.5)
        if answers:
            at_each_tick(estimator)
        answers.append(estimator.step(TORQUES[SINCE + 1], SPEEDS[SINCE + 1])[0].copy())
    one, other = answers
    np.testing.assert_allclose(one[[NOW, FORECAST]], other[[NOW, FORECAST]], atol=0.05)
