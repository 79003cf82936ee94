"""The pictures of the accuracy page, and the tare of the real well."""

from pathlib import Path

import numpy as np

from tests.accuracy import pictures
from tests.accuracy.field import TURNING, tared
from tests.accuracy.score import Answer
from tests.strings import BIT, COLLAR, DRIVE, PIPE, rig

RIG = rig(PIPE, COLLAR, bit=BIT, top_drive=DRIVE)


def test_a_longer_lag_and_quieter_rock_leave_less_error() -> None:
    of = pictures.trade(RIG, np.array([0.1, 1.0]))
    assert of.std.shape == (2, 4, 2)
    assert np.all(of.std[..., 1] < of.std[..., 0])
    assert of.rock[0] < of.rock[1]
    assert np.all(of.std[0] < of.std[1])


def test_pictures_are_written(tmp_path: Path) -> None:
    time = np.linspace(20, 50, 301)
    waves = np.sin(time)
    kinds = {
        f"{kind}_{name}": waves
        for kind in ("confirmed", "now", "forecast")
        for name in ("speed_rad_s", "speed_std_rad_s", "torque_nm", "torque_std_nm")
    }
    told = {"time_s": time, "confirmed_time_s": time - 1, "forecast_time_s": time + 1, **kinds}
    surface = {"time_s": time, "motor_speed_rad_s": waves}
    truth = {"time_s": time, "bit_speed_rad_s": waves, "bit_torque_nm": waves}
    work = pictures.at_work(told, surface, truth)
    lag = pictures.lag(pictures.trade(RIG, np.array([0.1, 1.0])), 0.5)
    for picture in (work, lag):
        assert f"({tmp_path.name}/{picture.name}.png)" in pictures.shown(picture, tmp_path)
        assert (tmp_path / f"{picture.name}.png").read_bytes().startswith(b"\x89PNG")


def test_a_tare_is_taken_while_the_bit_turns_and_in_its_time() -> None:
    time = np.arange(4.0)
    speed = np.array([TURNING / 2, TURNING * 2, np.nan, TURNING * 2])
    torque = np.array([1e4, 300.0, np.nan, 1e4])
    assert tared(Answer(time, speed, speed, torque, torque), 2.0) == 300.0
