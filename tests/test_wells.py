"""The sensor on simulated wells whose truth is known, and the wells themselves."""

import numpy as np
import pytest

from tests.accuracy import wells
from tests.accuracy.score import Score
from tests.accuracy.wells import KINDS, held, scores, told
from tests.leapfrog import Floats, Record
from tests.wells import CASES, Case, rig_of, surface, usual
from vsensor.estimator import component
from vsensor.estimator.estimator import Estimator
from vsensor.jit import COMPILED

pytestmark = pytest.mark.skipif(not COMPILED, reason="minutes of a rig: too slow without the compiler")

SHARES = {
    "400m": 0.02,
    "800m": 0.0085,
    "2500m": 0.0075,
    "tapered": 0.01,
    "hard": 0.025,
    "stuck": 0.0125,
    "dropped": 0.0075,
    "repeated": 0.0085,
}
"""Of the true bit speed's range, what the rms error of the confirmed one may be."""
TORQUES = {"hard": 1200.0}
"""What that of the torque may be, N·m: elsewhere 400."""


def kept(name: str, confirmed: Score) -> bool:
    return confirmed.share <= SHARES[name] and confirmed.torque <= TORQUES.get(name, 400.0)


@pytest.mark.parametrize("name", SHARES)
def test_the_bit_is_that_of_the_well_and_errors_are_as_large_as_is_stated(name: str) -> None:
    of = dict(zip(KINDS, scores(CASES[name]), strict=True))
    assert kept(name, of["confirmed"])
    for kind, one in of.items():
        assert 0.85 <= one.speed_within <= 0.999, kind
        assert 0.85 <= one.torque_within <= 0.9999, kind


def test_few_readings_are_doubted_for_it() -> None:
    """What lies between two of them is as wrong as they are: taken for ten of them, 85 % would be within."""
    for kind, one in zip(KINDS, scores(CASES["repeated"]), strict=True):
        assert one.speed_within >= 0.92, kind


def test_when_the_bit_broke_loose_and_how_its_collars_ring_is_doubted() -> None:
    """Believed to be as the model has it, 89 % of the confirmed speed's errors would be within."""
    confirmed = scores(CASES["hard"])[0]
    assert confirmed.speed_within >= 0.95
    assert confirmed.torque_within >= 0.95


def test_a_string_that_is_told_wrongly_is_found_out() -> None:
    """A tenth of the pipe is not told of: the bounds above would not be kept."""
    case = CASES["2500m"]
    record = case.record()
    shorter = rig_of(usual(2250))
    assert not kept("2500m", held(told(shorter, record), record)[0])


def test_off_bottom_there_is_soon_no_rock() -> None:
    """The string turns from 5 s on; a rock of 400 N·m is held to be there at first."""
    case = CASES["lateral"]
    read = surface(case.record())
    sensor = Estimator(case.rig)
    seen = round(25 * case.rig.loop.rate)
    sensor.run(read.motor_torque_nm[:seen], read.motor_speed_rad_s[:seen])
    assert sensor.rock_std < 30


def test_a_well_is_told_as_it_is() -> None:
    well = CASES["lateral"].well
    rig = rig_of(well)
    for told_of, true in zip(rig.string, well.string, strict=True):
        assert component.delay(told_of) == pytest.approx(true.travel_s)
        assert told_of.static_friction * true.length == pytest.approx(true.fs * true.length)
        assert told_of.coulomb_friction == true.fd
    assert (rig.top_drive.inertia, rig.bit.inertia) == (well.drive_inertia, well.bit_inertia)


def record_of(torque: Floats) -> Record:
    """Thirty seconds in which nothing but the torque reading matters."""
    time = np.arange(1, len(torque) + 1) / 100
    return Record(time, torque, np.full_like(time, 1.0), time, time)


def test_readings_are_spoilt_as_told_and_the_truth_is_not() -> None:
    plain = record_of(np.random.default_rng(1).normal(5e3, 1e3, 3000))
    spoilt = {
        name: CASES[name].spoilt(plain) for name in ("steps", "missing", "stuck", "dropped", "repeated")
    }
    for one in spoilt.values():
        np.testing.assert_array_equal(one.bit_torque, plain.bit_torque)
    assert not np.any(spoilt["steps"].motor_torque % 100)
    assert np.isnan(spoilt["missing"].motor_torque).sum() == 149  # at 0, 14 and 28 s, of torque,
    assert np.isnan(spoilt["missing"].motor_speed).sum() == 100  # and at 7 and 21 s of speed
    still = np.diff(spoilt["stuck"].motor_torque) == 0
    assert still.sum() == 48 + 4 * 50
    assert (spoilt["dropped"].motor_speed == 0).sum() == 49 + 4 * 50
    assert (np.diff(spoilt["repeated"].motor_torque) != 0).sum() == 299


def test_missing_readings_reach_the_sensor_as_such() -> None:
    case = Case("", usual(400)._replace(duration=8.0), CASES["missing"].spoilt)
    assert surface(case.record()).samples == (800 - 49, 800 - 50)


def test_each_well_has_a_row_as_wide_as_the_head(monkeypatch: pytest.MonkeyPatch) -> None:
    short = Case("a well", usual(150)._replace(duration=12.0))
    monkeypatch.setattr(wells, "CASES", {"one": short, "other": short._replace(words="another")})
    head, *rows = wells.section()
    assert [row.split(" | ")[0] for row in rows] == ["| a well", "| another"]
    assert {row.count("|") for row in rows} == {head.splitlines()[-1].count("|")}
