"""Cases whose truth was made by a method that shares nothing with ours, and a real well."""

from pathlib import Path

import numpy as np
import pytest

from tests.accuracy.reference import Case
from tests.accuracy.sticks import Foretold
from tests.accuracy.tare import off_bottom_first
from tests.accuracy.wrong import wrongs
from tests.cases import Columns, estimated, folder, midpoints, reference_rig, run, table
from tests.clocks import clock_rate, set_right
from vsensor.config import load
from vsensor.estimator.sections import Floats


@pytest.fixture(scope="module", params=["stick_slip", "smooth_drilling", "deviated_off_bottom"])
def case(request: pytest.FixtureRequest) -> tuple[str, Columns, Columns]:
    """A case by name, what is told of it, and its truth."""
    cases, name = folder("VSENSOR_REFERENCE_DATA"), str(request.param)
    told = estimated(reference_rig(cases / f"{name}.json"), cases / f"{name}_surface.csv")
    return name, told, table(cases / f"{name}_downhole.csv")


SPEED, TORQUE = ("speed", "rad_s"), ("torque", "nm")
RPM = np.pi / 30


def errors(told: Columns, truth: Columns, kind: str, quantity: tuple[str, str]) -> tuple[Floats, Floats]:
    """What one kind of answer misses from the tenth second on, and the deviations stated with it."""
    name, unit = quantity
    when = told["time_s" if kind == "now" else f"{kind}_time_s"]
    value, deviation = told[f"{kind}_{name}_{unit}"], told[f"{kind}_{name}_std_{unit}"]
    scored = np.isfinite(when) & np.isfinite(value) & (when >= 10) & (when <= truth["time_s"][-1])
    true = np.interp(when[scored], truth["time_s"], truth[f"bit_{name}_{unit}"])
    return value[scored] - true, deviation[scored]


def rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


SHARES = {
    ("stick_slip", "confirmed"): 0.005,
    ("stick_slip", "now"): 0.025,
    ("stick_slip", "forecast"): 0.025,
    ("smooth_drilling", "confirmed"): 0.015,
    ("deviated_off_bottom", "confirmed"): 0.015,
}
"""Of the true bit speed's range, what the rms error of its speed may be."""


def test_the_bit_is_that_of_the_reference(case: tuple[str, Columns, Columns]) -> None:
    name, told, truth = case
    span = np.ptp(truth["bit_speed_rad_s"][truth["time_s"] >= 10])
    for kind in ("confirmed", "now", "forecast"):
        if limit := SHARES.get((name, kind)):
            assert rms(errors(told, truth, kind, SPEED)[0]) <= limit * span, kind
    torque, _ = errors(told, truth, "confirmed", TORQUE)
    assert rms(torque) <= 300
    assert abs(np.mean(torque)) < 100


TOO_WIDE = {("deviated_off_bottom", "now"), ("deviated_off_bottom", "forecast")}
"""Asked are 90 to 99 %. Off bottom hardly anything is missed, and the deviations hold what parameters may be
wrong by, which none is here: more than 99.9 % of the errors are within, by less than twice too wide."""


@pytest.mark.parametrize("kind", ["confirmed", "now", "forecast"])
def test_errors_of_speed_are_as_large_as_is_stated(case: tuple[str, Columns, Columns], kind: str) -> None:
    """Within two stated deviations: 95 % of the errors were they normal and the statement exact."""
    name, told, truth = case
    error, deviation = errors(told, truth, kind, SPEED)
    assert len(error) > 1000
    within = np.mean(np.abs(error) <= 2 * deviation)
    assert within >= 0.90
    assert within <= 0.999 or (name, kind) in TOO_WIDE
    assert rms(error / deviation) >= 0.5


WARM_S = 8.0
"""The string of the step has stood so long before, longer than warming up takes."""


def test_the_papers_step_is_its_closed_form_away_from_the_fronts() -> None:
    """ω₁ = (2T₀/(ζ+D)) (1 − exp(−(ζ+D)(t−θ)/J)) from θ to 3θ, to 0.5 % of the steady speed T₀/D.

    Not to 0.5 % of each value: the record's own surface speed rings by ± 3 % about its closed form.
    """
    cases = folder("VSENSOR_REFERENCE_DATA")
    rig = reference_rig(cases / "paper_step.json")
    told = estimated(rig, cases / "paper_step_surface.csv", rest_s=WARM_S)
    theta, zeta, damping, inertia, torque = 1.268798, 733.009, 400.0, 2500.0, 7000.0
    when = told["confirmed_time_s"] - WARM_S
    front = 0.4  # s: how far to either side a front is felt
    smooth = (when > theta + front) & (when < 3 * theta - front)
    assert smooth.sum() > 100
    rate = (zeta + damping) / inertia
    exact = 2 * torque / (zeta + damping) * -np.expm1(-rate * (when[smooth] - theta))
    np.testing.assert_allclose(told["confirmed_speed_rad_s"][smooth], exact, atol=0.005 * torque / damping)


@pytest.fixture(scope="module")
def well() -> Path:
    """The folder of the real well: Well B, 1733 m, off bottom."""
    return folder("VSENSOR_FIELD_DATA")


@pytest.fixture(scope="module")
def heard(well: Path) -> list[tuple[Floats, Floats]]:
    """Times and bit speeds that are confirmed of the real well.

    Where parts of the string stick to the wall a hair may decide which, so the record is heard five times,
    its torque changed by up to a thousandth, and the middle one counts.
    """
    rig = load(Path(__file__).parent.parent / "config" / "well-b.toml")
    runs = []
    for more in (0.0, 1e-4, -1e-4, 1e-3, -1e-3):
        told = estimated(rig, well / "well_b_1733m_surface.csv", torque_scale=1 + more)
        known = np.isfinite(told["confirmed_time_s"])
        runs.append((told["confirmed_time_s"][known], told["confirmed_speed_rad_s"][known]))
    return runs


def test_a_real_well_is_followed(well: Path, heard: list[tuple[Floats, Floats]]) -> None:
    """Measured are 11.7 rpm and r 0.9856 by the downhole clock as it stands."""
    truth = table(well / "well_b_1733m_downhole.csv")
    missed, r = np.median([midpoints(*run, truth) for run in heard], axis=0)
    assert missed <= 12.5 * RPM
    assert r >= 0.985


def test_a_real_well_is_followed_closely_by_one_clock(well: Path, heard: list[tuple[Floats, Floats]]) -> None:
    """The surface's torque and the bit's speed swing together, yet the records give them two periods.

    The downhole clock is set right by the ratio of these, which no model has a part in. Measured are
    7.3 rpm and r 0.996.
    """
    truth, surface = (table(well / f"well_b_1733m_{name}.csv") for name in ("downhole", "surface"))
    rate = clock_rate(surface, truth)
    assert 1.005 < rate < 1.008
    missed, r = np.median([midpoints(*run, set_right(truth, rate)) for run in heard], axis=0)
    assert missed <= 8 * RPM
    assert r >= 0.995


@pytest.mark.parametrize("name", ["stick_slip", "smooth_drilling", "deviated_off_bottom"])
def test_all_that_is_wrong_costs_little_after_a_tare(name: str) -> None:
    """Speed and torque within three times what the right configuration is allowed."""
    cases = folder("VSENSOR_REFERENCE_DATA")
    right = reference_rig(cases / f"{name}.json")
    truth = table(cases / f"{name}_downhole.csv")
    span = np.ptp(truth["bit_speed_rad_s"][truth["time_s"] >= 10])
    wrong = wrongs(right)["all, load law +50 %"]
    told = run(wrong, cases / f"{name}_surface.csv", learned=off_bottom_first(wrong, right)).told
    assert rms(errors(told, truth, "confirmed", SPEED)[0]) <= 3 * SHARES[name, "confirmed"] * span
    assert rms(errors(told, truth, "confirmed", TORQUE)[0]) <= 3 * 300


def foretold(name: str) -> Foretold:
    return Case(folder("VSENSOR_REFERENCE_DATA"), name, "", 0.0).sticks


def test_every_stick_is_foretold_four_fifths_of_the_delay_ahead() -> None:
    """Fourteen come; of the first ones the law is not known yet, and three would be forgiven."""
    sticks, horizon = foretold("stick_slip")
    assert sticks.foretold >= 11
    assert sticks.missed <= 3
    assert sticks.false == 0
    assert sticks.lead_s >= 0.8 * horizon


@pytest.mark.parametrize("name", ["smooth_drilling", "deviated_off_bottom"])
def test_no_stick_is_foretold_in_vain(name: str) -> None:
    """In the lateral one comes as foretold, while the string still breaks loose."""
    sticks, _ = foretold(name)
    assert sticks.false == 0
    assert sticks.foretold <= 1
