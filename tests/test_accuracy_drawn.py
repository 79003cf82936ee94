"""Wells told as wrongly as is stated: what is drawn, and that the sensor is held to its word."""

import numpy as np
import pytest

from tests.accuracy import drawn
from tests.accuracy.drawn import chances, scores
from tests.accuracy.wells import KINDS
from tests.wells import CASES, Case, usual
from vsensor.estimator import component
from vsensor.jit import COMPILED

HELD = ("800m", "2500m", "6000m", "lateral")
"""Wells that together ring, stick and slip, are long, and rub."""


def test_what_is_drawn_is_normal_and_each_parameter_for_itself() -> None:
    each = chances(25).reshape(-1, drawn.PARAMETERS)
    np.testing.assert_allclose(each.mean(axis=0), 0.0, atol=0.02)
    np.testing.assert_allclose(each.std(axis=0), 1.0, atol=0.03)
    alike = np.corrcoef(each, rowvar=False) - np.eye(drawn.PARAMETERS)
    assert np.abs(alike).max() < 0.25


def test_a_rig_is_told_as_wrongly_as_is_drawn() -> None:
    right = CASES["lateral"].rig
    wrong = drawn.drawn(right, np.array([1.0, -2.0, 0.5, -1.0]))
    for true, told in zip(right.string, wrong.string, strict=True):
        assert component.delay(true) / component.delay(told) == pytest.approx(1.01)
        assert component.impedance(true) / component.impedance(told) == pytest.approx(0.96)
        assert true.coulomb_friction == pytest.approx(0.75 * told.coulomb_friction)
    assert right.top_drive.inertia / wrong.top_drive.inertia == pytest.approx(1.025)


@pytest.mark.skipif(not COMPILED, reason="minutes of a rig: too slow without the compiler")
def test_the_sensor_is_wrong_by_what_it_says() -> None:
    """About 95 % are within two deviations, over wells and what may be wrong of them."""
    wells = dict(zip(CASES, chances(len(CASES)), strict=True))
    of = [scores(CASES[name], wells[name]) for name in HELD]
    for kind, each in zip(KINDS, zip(*of, strict=True), strict=True):
        assert 0.92 <= np.mean([one.speed_within for one in each]) <= 0.985, kind
        assert 0.92 <= np.mean([one.torque_within for one in each]) <= 0.99, kind


@pytest.mark.skipif(not COMPILED, reason="minutes of a rig: too slow without the compiler")
def test_each_well_has_a_row_as_wide_as_the_head(monkeypatch: pytest.MonkeyPatch) -> None:
    short = Case("a well", usual(150)._replace(duration=12.0))
    monkeypatch.setattr(drawn, "CASES", {"one": short, "other": short._replace(words="another")})
    head, *rows = drawn.section(("one", "other"))
    assert [row.split(" | ")[0] for row in rows] == ["| a well", "| another", "| *mean*"]
    assert {row.count("|") for row in rows} == {head.splitlines()[-1].count("|")}
