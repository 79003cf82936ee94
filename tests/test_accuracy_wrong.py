"""Configurations wrong on purpose are wrong in what they say, and in nothing else."""

import numpy as np
import pytest

from tests.accuracy.wrong import (
    rough_law,
    wrong_friction,
    wrong_inertia,
    wrong_law,
    wrong_modulus,
    wrong_wall,
    wrongs,
)
from tests.strings import BIT, COLLAR, DRIVE, PIPE, rig
from vsensor.config import Bit, Rig
from vsensor.estimator import component

RIG = rig(
    PIPE.model_copy(update={"coulomb_friction": 0.3, "static_friction": 0.4}),
    COLLAR,
    bit=BIT,
    top_drive=DRIVE,
)


def test_a_wrong_modulus_slows_the_wave_and_nothing_else() -> None:
    wrong = wrong_modulus(RIG)
    for part, right in zip(wrong.string, RIG.string, strict=True):
        assert component.delay(part) == pytest.approx(component.delay(right) / np.sqrt(0.97))
        assert part.model_copy(update={"shear_modulus": right.shear_modulus}) == right
    assert wrong.model_copy(update={"string": RIG.string}) == RIG


def test_a_wrong_wall_raises_the_impedance_and_not_the_waves_travel_time() -> None:
    wrong = wrong_wall(RIG)
    for part, right in zip(wrong.string, RIG.string, strict=True):
        assert part.outer_diameter - part.inner_diameter == pytest.approx(
            1.05 * (right.outer_diameter - right.inner_diameter)
        )
        assert component.delay(part) == pytest.approx(component.delay(right))
        assert component.impedance(part) > 1.005 * component.impedance(right)
        assert part.model_copy(update={"inner_diameter": right.inner_diameter}) == right
    assert wrong.model_copy(update={"string": RIG.string}) == RIG


def test_a_wrong_inertia_is_the_top_drives_alone() -> None:
    wrong = wrong_inertia(RIG)
    assert wrong.top_drive.inertia == pytest.approx(2200.0)
    assert wrong.model_copy(update={"top_drive": RIG.top_drive}).top_drive == RIG.top_drive
    assert (wrong.string, wrong.bit) == (RIG.string, RIG.bit)


def test_wrong_friction_is_the_walls_of_every_kind() -> None:
    pipe = wrong_friction(RIG).string[0]
    assert (pipe.viscous_friction, pipe.coulomb_friction, pipe.static_friction) == pytest.approx(
        (0.014, 0.21, 0.28)
    )
    assert (wrong_friction(RIG).bit, wrong_friction(RIG).top_drive) == (RIG.bit, RIG.top_drive)


def test_a_wrong_law_is_wrong_at_every_speed_alike() -> None:
    bit = wrong_law(RIG, 1.5).bit
    assert (bit.viscous_friction, bit.kinetic_torque, bit.static_torque) == (7.5, 4500.0, 12000.0)
    assert (bit.inertia, bit.stribeck_speed) == (RIG.bit.inertia, RIG.bit.stribeck_speed)


def test_a_rough_law_knows_nothing_but_the_bits_inertia() -> None:
    assert rough_law(RIG).bit == Bit(inertia=RIG.bit.inertia, kinetic_torque=1e3)


def test_each_wrong_rig_is_one_that_a_file_could_give_and_differs_from_the_others() -> None:
    rigs = list(wrongs(RIG).values())
    assert rigs[0] is RIG
    for one in rigs:
        assert Rig.model_validate(one.model_dump()) == one
    assert len({one.model_dump_json() for one in rigs}) == len(rigs) == 9


def test_all_together_is_each_at_once() -> None:
    both = wrongs(RIG)["all, load law +50 %"]
    assert both.string == wrong_modulus(wrong_friction(RIG)).string
    assert both.top_drive == wrong_inertia(RIG).top_drive
    assert both.bit == wrong_law(RIG, 1.5).bit
