"""A state that was damaged, or made to do harm, is refused by name: kernels index by it, unchecked."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.rigs import SHORT, simulated
from vsensor.estimator.estimator import Estimator

Arrays = dict[str, NDArray[np.generic]]
FAR = 1 << 62


@pytest.fixture(scope="module")
def estimator() -> Estimator:
    return Estimator(SHORT)


@pytest.fixture(scope="module")
def saved(estimator: Estimator) -> Arrays:
    """What is remembered after some seconds of drilling."""
    estimator.reset()
    readings = simulated(8)
    estimator.run([r.motor_torque for r in readings], [r.motor_speed for r in readings])
    return estimator.save()


def with_one(saved: Arrays, name: str, place: int, value: float) -> Arrays:
    damaged = saved[name].copy()
    damaged.flat[place] = value
    return {**saved, name: damaged}


HARM = [
    ("level", 0, 10**9),
    ("level", 0, -10),
    ("levels", 3, 10**9),
    ("levels", 3, -1),
    ("learned.stop", 1, 10**9),
    ("learned.stop", 1, -1),
    ("learned.stop", 0, -1),
    ("ticks", 0, -1),
    ("ticks", 0, FAR),
    ("ticks", 1, 10**6),
    ("last_seen", 0, 10**6),
    ("last_seen", 0, -1),
    ("off_bottom", 0, -FAR),
    ("course", 0, FAR),
    ("course", 1, 0),
    ("course", 2, -FAR),
    ("missing", 0, 2),
    ("scores.scored", 0, -1),
    ("scores.sums", 0, 0.0),
    ("scores.sums", 2, -1.0),
    ("scores.sums", 0, np.nan),
    ("scores.law", 0, -1.0),
    ("scores.foretold", -1, 0.0),
    ("scores.foretold", -1, np.nan),
    ("tuning.value", 0, 5.0),
    ("tuning.value", 0, np.nan),
    ("tuning.value", 1, 0.061),
    ("tuning.value", 3, -0.76),
    ("tuning.prior", 0, 1.0),
    ("tuning.variance", 0, -1e-9),
    ("tuning.information", 0, -1.0),
    ("tuning.information", 1, 1.0),
    ("tuning.misfit", 1, -1.0),
    ("tuning.crossed", 0, np.nan),
    ("tuning.steady", 0, FAR),
    ("learned.normal", 0, -1.0),
    ("learned.normal", 1, 1e9),
    ("learned.fits", 0, np.inf),
    ("learned.fits", 1, 1e9),
    ("learned.law", 0, 1e9),
    ("learned.speeds", 0, 0.0),
    ("learned.scale", 0, -1.0),
    ("learned.idle", 0, 3),
    ("learned.idle", 1, -1),
    ("surprise", 0, -1.0),
    ("steps", 0, -1.0),
    ("resolution", 0, np.nan),
    ("bends", 1, -1.0),
    ("lasts", 0, 0.5),
    ("white", 0, -1.0),
    ("noisier", 0, 0.5),
    ("rock_square", 0, 0.0),
    ("waves", 5, np.nan),
    ("waves", 5, 1e300),
    ("innovation", 0, np.inf),
    ("held", 0, -1.0),
    ("slips", 0, -1.0),
]


@pytest.mark.parametrize(("name", "place", "value"), HARM)
def test_a_number_that_would_do_harm_is_refused_by_name(
    estimator: Estimator, saved: Arrays, name: str, place: int, value: float
) -> None:
    estimator.restore(saved)
    with pytest.raises(ValueError, match=rf"^saved state: {name.replace('.', '[.]')} holds .* is right"):
        estimator.restore(with_one(saved, name, place, value))
    now = estimator.save()
    assert all(np.array_equal(now[each], saved[each], equal_nan=True) for each in saved)


def test_the_same_holds_of_what_was_learned(estimator: Estimator, saved: Arrays) -> None:
    estimator.restore(saved)
    learned = estimator.learned()
    for name, place, value in HARM:
        if name in learned:
            with pytest.raises(ValueError, match=f"^saved state: {name}"):
                estimator.begin_with(with_one(learned, name, place, value))


def test_the_refusal_says_what_was_found_and_what_would_be_right(estimator: Estimator, saved: Arrays) -> None:
    with pytest.raises(ValueError, match="level holds 1000000000 where 0 to 9 is right"):
        estimator.restore(with_one(saved, "level", 0, 10**9))
    with pytest.raises(ValueError, match=r"tuning\.value holds 5 where -0\.03\d* to 0\.03\d* is right"):
        estimator.restore(with_one(saved, "tuning.value", 0, 5.0))


def test_of_arrays_that_differ_only_the_missing_and_the_unknown_are_told(
    estimator: Estimator, saved: Arrays
) -> None:
    other = {name: array for name, array in saved.items() if name != "ticks"}
    with pytest.raises(ValueError, match=r"^the saved state lacks ticks, and holds tocks unknown to this"):
        estimator.restore({**other, "tocks": saved["ticks"]})
