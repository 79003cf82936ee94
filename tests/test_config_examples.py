"""The examples in config/ are what they say they are."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from vsensor.cli.main import app
from vsensor.config import Rig, load
from vsensor.estimator import component
from vsensor.estimator.estimator import Estimator

EXAMPLES = Path(__file__).parent.parent / "config"


def example(name: str) -> Rig:
    return load(EXAMPLES / f"{name}.toml")


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.toml")), ids=lambda file: file.stem)
def test_an_example_loads_and_passes_check(file: Path) -> None:
    result = CliRunner().invoke(app, ["check", str(file)])
    assert result.exit_code == 0
    assert load(file).rig.name in result.output


def test_the_examples_are_there() -> None:
    assert {"deviated", "drilling", "paper", "well-b"} <= {file.stem for file in EXAMPLES.glob("*.toml")}


def test_drilling_is_the_demo_and_looks_sound() -> None:
    result = CliRunner().invoke(app, ["check", str(EXAMPLES / "drilling.toml")])
    assert example("drilling").rig.name == "demo"
    assert "Nothing looks odd." in result.output


def test_deviated_has_its_friction_from_the_survey_and_looks_sound() -> None:
    result = CliRunner().invoke(app, ["check", str(EXAMPLES / "deviated.toml")])
    assert "Nothing looks odd." in result.output
    rig = example("deviated")
    assert sum(part.length for part in rig.string) - rig.survey[-1].measured_depth == pytest.approx(25)
    friction = Estimator(rig).line.kinetic
    assert friction.sum() == pytest.approx(9.84e3, rel=1e-3)  # a torque that such wells have off bottom


def test_paper_has_the_papers_line() -> None:
    (pipe,) = example("paper").string
    assert component.polar_moment(pipe) == pytest.approx(2.903111e-5, rel=1e-6)
    assert component.wave_speed(pipe) == pytest.approx(3152.59, rel=1e-6)
    assert component.impedance(pipe) == pytest.approx(733.009, rel=1e-6)
    assert component.delay(pipe) == pytest.approx(1.268798, rel=1e-6)
    assert component.stiffness(pipe) == pytest.approx(577.719, rel=1e-6)
    assert component.inertia(pipe) == pytest.approx(930.041, rel=1e-6)
    bit = example("paper").bit
    assert 7000 / bit.viscous_friction == 17.5
    assert bit.inertia == 2500


def test_well_b_reaches_its_depth() -> None:
    rig = example("well-b")
    assert sum(part.length for part in rig.string) == pytest.approx(1733)
    assert sum(part.length for part in rig.string[1:]) == pytest.approx(230.46)
    assert rig.top_drive.inertia == 2900
