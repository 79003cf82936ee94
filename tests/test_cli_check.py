"""`vsensor check` explains a configuration, and points out likely slips without refusing them."""

import math
import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from vsensor.cli.main import app
from vsensor.cli.oddities import oddities
from vsensor.config import Rig, load
from vsensor.estimator.estimator import Estimator

SOUND: dict[str, Any] = {
    "rig": {"name": "sound"},
    "string": [
        {"name": "pipe", "length": 2000, "outer_diameter": "5 in", "inner_diameter": "108.6 mm"},
        {
            "name": "[b]collar",
            "length": 200,
            "outer_diameter": "6.5 in",
            "inner_diameter": 0.07,
            "coulomb_friction": 4,
        },
    ],
    "top_drive": {"inertia": 2000},
    "bit": {"inertia": 50, "kinetic_torque": 3000, "static_torque": 8000},
}


WELL: dict[str, Any] = {
    "string": [part | {"coulomb_friction": 0} for part in SOUND["string"]],
    "survey": [
        {"measured_depth": 1000, "inclination": 0, "azimuth": 0},
        {"measured_depth": 2150, "inclination": "30 deg", "azimuth": "140 deg"},
    ],
    "wellbore": {"mud_density": "1.2 g/cm^3", "friction_factor": 0.1},
}


def surveyed(**changed: object) -> Rig:
    """The sound rig with its friction from a survey, and its wellbore changed."""
    return Rig.model_validate(SOUND | WELL | {"wellbore": WELL["wellbore"] | changed})


def sound(section: str, **changed: object) -> Rig:
    """The sound rig with one table changed."""
    return Rig.model_validate(SOUND | {section: SOUND.get(section, {}) | changed})


def with_part(number: int, **changed: object) -> Rig:
    """The sound rig with one component changed."""
    parts = [dict(part) for part in SOUND["string"]]
    parts[number] |= changed
    return Rig.model_validate(SOUND | {"string": parts})


def test_a_sound_rig_has_nothing_odd() -> None:
    assert oddities(Rig.model_validate(SOUND)) == []


@pytest.mark.parametrize(
    ("rig", "oddity"),
    [
        (with_part(0, length="20 km"), "string: 20200 m in all"),
        (Rig.model_validate(SOUND | {"string": [SOUND["string"][1] | {"length": 5}]}), "string: 5 m in all"),
        (with_part(1, length=0.2), 'string[2] "[b]collar": a wave runs 0.2 m in 0.0063 of a tick'),
        (with_part(0, density=7000), 'string[1] "pipe": wave speed 3366 m/s'),
        (with_part(0, shear_modulus="61 GPa"), 'string[1] "pipe": wave speed 2788 m/s'),
        (
            with_part(1, outer_diameter="12 in"),
            'string[2] "[b]collar": 71 times the impedance of "pipe" above',
        ),
        (
            Rig.model_validate(SOUND | {"string": [SOUND["string"][1] | {"outer_diameter": 6.5}]}),
            'string[1] "[b]collar": 6.5 m across: is the unit right',
        ),
        (
            sound("loop", rate="10 Hz"),
            "loop.rate is 10 Hz: leave it at 100 Hz even where samples come no",
        ),
        (with_part(0, tensile_strength="3 MN"), 'string[1] "pipe": tensile_strength alone limits nothing'),
        (
            with_part(0, tensile_strength="500 kN", torsional_strength="50 kN*m"),
            'string[1] "pipe": 794568 N hang on it in air',
        ),
        (with_part(1, coulomb_friction=0), "string: 2200 m without any friction"),
        (with_part(1, coulomb_friction=50), "bit.static_torque 8000 N·m is less than the wall's 10000 N·m"),
        (sound("top_drive", inertia=0), "top_drive: neither inertia nor gear"),
        (sound("bit", inertia=0), "bit.inertia is 0"),
        (sound("measurement", torque_noise=0), "measurement.torque_noise is 0"),
        (sound("measurement", speed_noise=0), "measurement.speed_noise is 0"),
        (
            sound("measurement", torque_limit="8 kN*m"),
            "measurement.torque_limit 8000 N·m is below the 8800 N·m",
        ),
        (
            sound("bus", listen=["tcp/0.0.0.0:7447"]),
            'bus.listen[1] "tcp/0.0.0.0:7447": open to other machines',
        ),
        (sound("bus", listen=["tcp/127.0.0.1:7447", "udp/[::]:7447"]), 'bus.listen[2] "udp/[::]:7447": open'),
        (sound("bus", listen=["tls/rig.example:7447"]), 'bus.listen[1] "tls/rig.example:7447": open'),
        (sound("bus", multicast_scouting=True), "bus.multicast_scouting is on"),
        (
            sound("loop", realtime="prefer", processors=[4095]),
            "loop.processors: this machine has none of number 4095",
        ),
        (
            Rig.model_validate(SOUND | WELL | {"survey": [s | {"inclination": 0} for s in WELL["survey"]]}),
            "string: 2200 m without any friction",
        ),
        (surveyed(mud_density=1.2), "wellbore.mud_density 1.2 kg/m³, where 800 to 2500 is usual"),
        (surveyed(friction_factor=0.9), "bit.static_torque 8000 N·m is less than the wall's"),
        (
            Rig.model_validate(
                SOUND | WELL | {"survey": [WELL["survey"][0], WELL["survey"][1] | {"measured_depth": 2000}]}
            ),
            "survey: ends 200 m above the bit",
        ),
    ],
)
def test_a_likely_slip_is_pointed_out(rig: Rig, oddity: str) -> None:
    (told,) = oddities(rig)
    assert told.startswith(oddity)


@pytest.mark.parametrize(
    "rig",
    [
        sound("top_drive", inertia=0, gear_ratio=8.5),
        with_part(0, viscous_friction=0.02),
        sound("bit", kinetic_torque=0, static_torque=0),  # nothing is known of the rock, or off bottom
        sound("measurement", torque_limit="9 kN*m"),
        surveyed(),
        sound("bus", listen=["tcp/127.0.0.1:1", "tcp/[::1]:1", "tcp/localhost:1", "unixsock-stream//run/z"]),
    ],
)
def test_what_is_usual_is_not_pointed_out(rig: Rig) -> None:
    assert oddities(rig) == []


def test_the_report_gives_the_figures(tmp_path: Path) -> None:
    file = tmp_path / "shaft.toml"
    # A uniform shaft: ζ, θ, ρJL, k and the modes (2n − 1)/(4θ) by hand, from physics.md section 1.
    file.write_text(
        """
        rig.name = "shaft"
        [[string]]
        name = "[b]shaft"
        length = "4000 m"
        outer_diameter = "168.2 mm"
        inner_diameter = "149.884 mm"
        shear_modulus = "79.6 GPa"
        density = "8009 kg/m³"
        coulomb_friction = "0.5 N·m/m"
        torsional_strength = "60 kN·m"
        tensile_strength = "2 MN"
        """,
        encoding="utf-8",
    )
    result = CliRunner().invoke(app, ["check", str(file)])
    assert result.exit_code == 0
    rows = [line.split() for line in result.output.splitlines()]
    assert ["[b]shaft", "4000.00", "168.2", "149.9", "733.01", "1268.80", "930.0", "2000"] in rows
    # It weighs ρgLπ(ro² − ri²) = 1437.5 kN: 60 √(1 − 0.7188²) = 41.7 kN·m are left at its top.
    assert ["[b]shaft", "1438", "41.7", "torsional", "strength", "under", "tension"] in rows
    for row in (
        "a wave's way down 1.2688 s",
        "and back up 2.5376 s",
        "static stiffness 577.7 N·m/rad",
        "wind-up 0.275 turns per kN·m",
        "wall friction 2.00 kN·m while turning",
        "mode 1 0.1970 Hz, period 5.08 s",
        "mode 4 1.3793 Hz, period 0.73 s",
    ):
        assert row.split() in rows
    assert "What looks odd (2)" in result.output
    assert "\x1b" not in result.output


def test_the_report_tells_how_well_the_bit_will_be_known() -> None:
    file = Path(__file__).parent.parent / "config" / "drilling.toml"
    sensor = Estimator(load(file))
    result = CliRunner().invoke(app, ["check", str(file)])
    rows = [" ".join(line.split()) for line in result.output.splitlines()]
    (noise,) = (row for row in rows if row.startswith("its noise"))
    speed, torque = (float(number) for number in re.findall(r"([\d.]+) (?:rpm|N·m)", noise))
    assert (speed * math.pi / 30, torque) == pytest.approx(sensor.noise.tolist(), rel=0.05)
    assert "middling rock" in noise
    assert f"band up to {sensor.bandwidth:.1f} Hz the rock is told more than guessed" in rows
    assert f"confirmed {sensor.confirmed_delay:.3f} s late" in rows
    assert sensor.confirmed_delay == pytest.approx(
        0.005 + 0.5 + 0.9, abs=0.02
    )  # drive, lag, 2850 m of string


def test_the_report_tells_of_the_well(tmp_path: Path) -> None:
    file = tmp_path / "well.toml"
    # A quarter circle of 1000 m radius and pipe that weighs w in mud: F = w (1000 m − depth), and at the top
    # N = F/R − 0 = w, at the bit N = w, by hand; between them w |1 − 2 sin I|, so that a third of the way
    # down the string leaves the upper side of the hole for the lower.
    file.write_text(
        """
        rig.name = "bend"
        [[string]]
        name = "pipe"
        length = 1570.7963267948966
        outer_diameter = 0.2
        inner_diameter = 0.1
        [[survey]]
        measured_depth = 0
        inclination = 0
        azimuth = "20 deg"
        [[survey]]
        measured_depth = 1570.7963267948966
        inclination = "90 deg"
        azimuth = "20 deg"
        [wellbore]
        mud_density = 850
        friction_factor = 0.2
        """,
        encoding="utf-8",
    )
    weight = 7000 * math.pi / 4 * (0.2**2 - 0.1**2) * 9.80665
    # ∫ |1 − 2 sin I| dI from 0 to 90° = 2√3 − 2 − π/6
    friction = 0.2 * 0.1 * weight * 1000 * (2 * math.sqrt(3) - 2 - math.pi / 6)
    result = CliRunner().invoke(app, ["check", str(file)])
    assert result.exit_code == 0
    for row in (
        f"wall friction {friction / 1e3:.2f} kN·m while turning",
        "bit 1000.0 m below surface",
        "inclination at the bit 90.0°",
        "sharpest dogleg 1.72° in 30 m, below 0 m",
    ):
        assert row.split() in [line.split() for line in result.output.splitlines()]
    assert f"greatest side force {weight / 1e3:.2f} kN/m" in " ".join(result.output.split())
    assert f"{friction:.0f}" in result.output
