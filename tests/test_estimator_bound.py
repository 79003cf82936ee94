"""Wall friction that is told too high: no bit drives its rock, so it is taken back."""

import numpy as np
import pytest

from tests.accuracy.score import rms
from tests.accuracy.wells import told, truth
from tests.accuracy.wrong import wrong_friction
from tests.cases import Columns
from tests.leapfrog import Record
from tests.wells import CASES, surface
from vsensor.config import Rig
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.tune import FRICTION
from vsensor.jit import COMPILED
from vsensor.quality import Reason

pytestmark = pytest.mark.skipif(not COMPILED, reason="minutes of a rig: too slow without the compiler")

ROUGH = 1.3
"""So many times the wall's friction is what is told."""


@pytest.fixture(scope="module")
def record() -> Record:
    """A lateral off bottom, turned up from rest; nobody tells that it is."""
    return CASES["lateral"].record()


def friction_of(rig: Rig, record: Record) -> float:
    """What is corrected of it in the end."""
    sensor, read = Estimator(rig), surface(record)
    sensor.run(read.motor_torque_nm, read.motor_speed_rad_s)
    return float(sensor.tuning[FRICTION])


def missed(estimates: Columns, kind: str, record: Record, since: float, until: float) -> float:
    """Rms error of bit speed over a time, rad/s."""
    when = estimates["time_s" if kind == "now" else f"{kind}_time_s"]
    use = (when >= since) & (when < until)
    true = truth(record)
    at = np.interp(when[use], true["time_s"], true["bit_speed_rad_s"])
    return rms(estimates[f"{kind}_speed_rad_s"][use] - at)


def test_friction_is_found_of_a_bit_off_bottom_that_nobody_told_of(record: Record) -> None:
    for factor in (ROUGH, 1.5):
        found = friction_of(wrong_friction(CASES["lateral"].rig, factor), record)
        assert found == pytest.approx(1 / factor - 1, abs=0.006)


def test_a_friction_that_is_right_or_too_low_stays_as_told(record: Record) -> None:
    for factor in (1.0, 1 / ROUGH):
        assert friction_of(wrong_friction(CASES["lateral"].rig, factor), record) == 0.0


def test_on_bottom_what_the_rock_takes_is_not_laid_to_the_wall() -> None:
    """Smooth drilling, and stick-slip: however rough the wall is told, the bit takes the most."""
    for name in ("smooth", "rubbed"):
        case = CASES[name]
        assert friction_of(wrong_friction(case.rig, ROUGH), case.record()) == 0.0


def test_the_bit_is_foretold_by_a_friction_that_was_found_and_the_correction_stirs_nothing(
    record: Record,
) -> None:
    """Before, the string is held to stop: *now* is 5 rad/s wrong."""
    rig = wrong_friction(CASES["lateral"].rig, ROUGH)
    estimates = told(rig, record)
    assert missed(estimates, "confirmed", record, 15, 35) < 0.2
    assert missed(estimates, "now", record, 10, 20) > 2.0
    assert missed(estimates, "now", record, 40, 90) < 0.3


@pytest.mark.parametrize("name", ["2500m", "lateral", "rubbed"])
def test_a_torque_that_no_friction_explains_is_not_good_and_corrects_nothing(name: str) -> None:
    """The cable is off from 40 to 70 s: what is read is an amplifier's noise, while the string turns on."""
    case = CASES[name]
    read = surface(case.record())
    torque, off = np.array(read.motor_torque_nm), slice(4000, 7000)
    torque[off] = np.random.default_rng(1).normal(0.0, 5.0, 3000)
    sensor = Estimator(case.rig)
    flagged = sensor.run(torque, read.motor_speed_rad_s).reasons & Reason.TORQUE_TOO_LOW != 0
    assert not flagged[:4000].any()
    assert flagged[6990:7000].all()
    assert not flagged[-100:].any()
    assert sensor.tuning[FRICTION] == 0.0
