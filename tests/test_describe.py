"""What the string is and how it lies, as it is told to whoever draws it."""

from pathlib import Path

import numpy as np
import pytest

from tests.rigs import SHORT
from vsensor.config import load
from vsensor.estimator import component
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.modes import torsional_modes
from vsensor.estimator.wellpath import vertical_depth, well_path
from vsensor.service.describe import EVERY_S, Describer, describe

DRILLING = load(Path("config/drilling.toml"))
DEVIATED = load(Path("config/deviated.toml"))


def test_stations_are_those_of_the_profile() -> None:
    assert list(describe(SHORT, SHORT.string).depth_m) == Estimator(SHORT).stations.depth.tolist()


def test_each_station_has_its_components_impedance_and_compliance() -> None:
    told = describe(DRILLING, DRILLING.string)
    pipe, _, collars = DRILLING.string
    for at, part in ((0, pipe), (-1, collars)):
        assert told.impedance_nm_s_rad[at] == component.impedance(part)
        assert told.compliance_rad_nm_m[at] * component.stiffness(part) * part.length == pytest.approx(1)
    assert list(told.component) == ["drill pipe", "heavy-weight drill pipe", "drill collars"]
    assert list(told.component_end_m) == [2500, 2700, 2850]


def test_without_a_survey_it_hangs_straight_down() -> None:
    told = describe(DRILLING, DRILLING.string)
    assert set(told.north_m) == set(told.east_m) == {0.0}
    assert list(told.vertical_depth_m) == list(told.depth_m)


def test_in_a_deviated_well_it_lies_along_the_path() -> None:
    told = describe(DEVIATED, DEVIATED.string)
    path = well_path(DEVIATED.survey)
    np.testing.assert_allclose(told.vertical_depth_m, vertical_depth(path, np.array(told.depth_m)))
    places = np.stack([told.north_m, told.east_m, told.vertical_depth_m], axis=1)
    steps, chords = np.diff(told.depth_m), np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert (chords <= steps + 1e-9).all()
    assert (chords >= 0.995 * steps).all()
    assert told.north_m[-1] < 0 < told.east_m[-1]  # an azimuth of some 140°


def test_modes_are_those_of_a_held_top() -> None:
    told = describe(DRILLING, DRILLING.string)
    held = torsional_modes(DRILLING.string, DRILLING.bit.inertia, len(told.mode_hz))
    assert list(told.mode_hz) == held.tolist()


def test_it_is_told_at_once_again_and_again_and_when_the_string_has_grown() -> None:
    estimator = Estimator(SHORT)
    describer = Describer(SHORT, estimator)
    told = [describer.second() for _ in range(EVERY_S + 1)]
    assert [description is not None for description in told] == [True] + [False] * (EVERY_S - 1) + [True]
    estimator.lengthen(28.5)
    longer = describer.second()
    assert longer is not None
    assert longer.depth_m[-1] == SHORT.string[0].length + 28.5
    assert describer.second() is None
