"""Answers are scored as by hand, and as by an independent program."""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tests.accuracy.score import Answer, answer, score, surface_speed
from tests.cases import estimated, folder, reference_rig, table


def test_a_score_worked_by_hand() -> None:
    time = np.arange(4.0)
    truth = {"time_s": time, "bit_speed_rad_s": np.array([9.0, 0, 2, 4]), "bit_torque_nm": np.full(4, 100.0)}
    told = Answer(
        time=time + 0.5,  # the last is later than the truth, the first earlier than what is scored
        speed=np.array([0.0, 2, 2, 2]),
        speed_std=np.array([1.0, 0.5, 0.4, 1]),
        torque=np.array([0.0, 90, 130, 0]),
        torque_std=np.full(4, 10.0),
    )
    of = score(told, truth, 1.0)
    assert of.speed == pytest.approx(1.0)
    assert of.share == pytest.approx(1 / 4)
    assert of.torque == pytest.approx(np.sqrt((10**2 + 30**2) / 2))
    assert of.bias == pytest.approx(10.0)
    assert (of.speed_within, of.torque_within) == (0.5, 0.5)


def test_surface_speed_says_nothing_of_torque() -> None:
    time = np.arange(3.0)
    truth = {"time_s": time, "bit_speed_rad_s": time, "bit_torque_nm": time}
    of = score(surface_speed({"time_s": time, "motor_speed_rad_s": time + 1}), truth, 0.0)
    assert of.speed == pytest.approx(1.0)
    assert np.isnan([of.torque, of.bias, of.speed_within, of.torque_within]).all()


def test_the_score_is_that_of_the_independent_scorer() -> None:
    data = folder("VSENSOR_REFERENCE_DATA")
    theirs = _scorer(data.parent / "score" / "score.py")
    told = estimated(reference_rig(data / "stick_slip.json"), data / "stick_slip_surface.csv")
    truth = table(data / "stick_slip_downhole.csv")
    expected = theirs.exact(told, truth, 10.0)
    for kind in ("confirmed", "now", "forecast"):
        of, by_them = score(answer(told, kind), truth, 10.0), expected[kind]
        assert of.speed == pytest.approx(by_them["speed_rmse_rad_s"])
        assert of.share == pytest.approx(by_them["speed_nrmse"])
        assert of.torque == pytest.approx(by_them["torque_rmse_nm"])
        assert of.bias == pytest.approx(by_them["torque_bias_nm"])
        assert of.speed_within == pytest.approx(by_them["cover2s"])


def _scorer(file: Path) -> ModuleType:
    if not file.exists():
        pytest.skip("score/score.py does not lie beside the reference cases")
    spec = importlib.util.spec_from_file_location("independent_score", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
