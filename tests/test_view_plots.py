"""Speed and torque over time: everything at its own time, in the units that people read."""

import math

import numpy as np
import pytest

from tests.view_rig import BEGUN_NS, DELAY_NS, bit_speed, description, estimate, profile, tick
from vsensor.messages import Estimate, Message, Profile
from vsensor.quality import Reason
from vsensor.view.batches import Batch, Look, Measured, Points
from vsensor.view.plots import Drive, Plots
from vsensor.view.units import Units

RPM = 60 / (2 * math.pi)
NS = 1_000_000_000


def drawn(*given: Message, plots: Plots | None = None) -> list[Batch]:
    plots = plots or Plots(Units(), Drive())
    for message in given:
        plots.hear(message, BEGUN_NS)
    return list(plots.batches())


def lines(batches: list[Batch]) -> dict[str, Points | Measured]:
    return {batch.entity: batch for batch in batches if isinstance(batch, Points | Measured)}


def test_surface_speed_and_torque_are_drawn_from_ticks() -> None:
    line = lines(drawn(tick(0), tick(7)))
    assert line["/speed/at_surface"].times_ns.tolist() == [BEGUN_NS, BEGUN_NS + 70_000_000]
    np.testing.assert_allclose(line["/speed/at_surface"].values, [10 * RPM, 10 * RPM])
    np.testing.assert_allclose(line["/torque/at_surface"].values, [7.0, 7.007])


@pytest.mark.parametrize(
    ("units", "speed", "torque"),
    [
        (Units("rpm", "kN*m"), 10 * RPM, 7.0),
        (Units("rad/s", "N*m"), 10.0, 7000.0),
        (Units("rpm", "kft*lbf"), 10 * RPM, 7000 / 1355.8179),
    ],
)
def test_units_are_those_that_were_asked_for(units: Units, speed: float, torque: float) -> None:
    line = lines(drawn(tick(0), estimate(0), plots=Plots(units, Drive())))
    assert line["/speed/at_surface"].values[0] == pytest.approx(speed)
    assert line["/torque/at_surface"].values[0] == pytest.approx(torque)
    bit = line["/torque/bit/now"]
    assert isinstance(bit, Measured)
    assert bit.values[0] == pytest.approx(torque * 3100 / 7000)
    assert bit.bands[0] == pytest.approx(torque * 2 * 200 / 7000)


def test_behind_a_gear_the_surface_is_drawn_as_the_string_feels_it() -> None:
    line = lines(drawn(tick(0), plots=Plots(Units(), Drive(8.0, 0.9))))
    np.testing.assert_allclose(line["/speed/at_surface"].values, [10 * RPM / 8])
    np.testing.assert_allclose(line["/torque/at_surface"].values, [7.0 * 8 * 0.9])


def test_the_gear_is_taken_from_what_the_sensor_tells_of_itself() -> None:
    geared = description()
    geared.gear_ratio, geared.efficiency = 8.0, 0.9
    line = lines(drawn(geared, tick(0)))
    np.testing.assert_allclose(line["/torque/at_surface"].values, [7.0 * 8 * 0.9])


def test_a_held_value_is_not_drawn_as_measured() -> None:
    held = tick(1)
    held.reasons = int(Reason.STALE_TORQUE)
    line = lines(drawn(tick(0), held, tick(2)))
    assert np.isfinite(line["/speed/at_surface"].values).all()
    assert np.isnan(line["/torque/at_surface"].values).tolist() == [False, True, False]


@pytest.mark.parametrize(("kind", "shift_ns"), [("confirmed", -DELAY_NS), ("now", 0), ("forecast", DELAY_NS)])
def test_each_answer_stands_at_the_time_for_which_it_holds(kind: str, shift_ns: int) -> None:
    numbers = range(200, 600, 2)
    line = lines(drawn(*(estimate(number) for number in numbers)))[f"/speed/bit/{kind}"]
    assert line.times_ns.tolist() == [BEGUN_NS + n * NS // 100 + shift_ns for n in numbers]
    truth = [bit_speed((time_ns - BEGUN_NS) / NS) * RPM for time_ns in line.times_ns.tolist()]
    np.testing.assert_allclose(line.values, truth, atol=1e-6)


def test_a_band_is_two_deviations_wide_to_each_side() -> None:
    line = lines(drawn(estimate(0)))["/torque/bit/now"]
    assert isinstance(line, Measured)
    np.testing.assert_allclose(line.values, [3.1])
    np.testing.assert_allclose(line.bands, [0.4])


def test_the_present_is_marked_once_a_turn_at_the_newest_now() -> None:
    line = lines(drawn(estimate(3), estimate(4)))["/speed/present"]
    assert line.times_ns.tolist() == [estimate(4).time_ns]
    np.testing.assert_allclose(line.values, [bit_speed(0.04) * RPM])


def test_what_is_not_known_yet_is_not_drawn() -> None:
    assert lines(drawn(Estimate(number=0, time_ns=BEGUN_NS))) == {}


def with_torque(number: int, top_nm: float, bit_nm: float) -> Profile:
    told = profile(number)
    told.torque_nm[0], told.torque_nm[-1] = top_nm, bit_nm
    return told


def test_limits_of_both_ends_are_drawn_each_second_and_named() -> None:
    batches = drawn(description(), *(with_torque(number, -30e3, 3e3) for number in range(0, 300, 10)))
    line = lines(batches)
    np.testing.assert_allclose(line["/torque/a_limit/at_surface"].values, [40.0] * 3)
    np.testing.assert_allclose(line["/torque/a_limit/at_bit"].values, [4.0] * 3)
    names = [batch.name for batch in batches if isinstance(batch, Look) and "limit" in batch.entity]
    assert names[-2:] == ["limit at surface: pipe", "limit at bit: collars"]


def test_a_limit_is_drawn_once_the_torque_comes_near_it_and_for_ten_seconds_more() -> None:
    peak = 530  # between two seconds
    told = [with_torque(number, 21e3 if number == peak else 19e3, 0.0) for number in range(0, 3000, 10)]
    line = lines(drawn(*told))
    assert line.keys() == {"/torque/a_limit/at_surface"}
    shown = line["/torque/a_limit/at_surface"]
    seconds = (shown.times_ns - profile(0).time_ns) / NS
    np.testing.assert_allclose(seconds, [*range(6, 16), 15], atol=1e-6)
    np.testing.assert_allclose(shown.values, [*[40.0] * 10, math.nan])


def test_where_no_strength_is_configured_no_limit_is_drawn() -> None:
    weak = profile(0)
    weak.torque_limit_nm[:] = [math.nan] * 11
    assert not any("limit" in entity for entity in lines(drawn(weak)))
