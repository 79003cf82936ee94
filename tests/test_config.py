"""A configuration comes out as frozen SI values, and goes into a session without loss."""

import math
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from vsensor.config import Component, Rig, effective_toml, load, loads
from vsensor.config.rig import MOST_BYTES
from vsensor.errors import ConfigError

SMALL = """
[rig]
name = "small"
[[string]]
length = "1000 ft"
outer_diameter = "5 in"
inner_diameter = "4 in"
"""

positive = st.floats(1e-9, 1e12)
from_zero = st.floats(0, 1e12)
words = st.text(min_size=1, max_size=30).filter(lambda text: text.isprintable() or "\n" not in text)
endpoints = st.lists(
    st.sampled_from(["tcp/127.0.0.1:7447", "udp/[::1]:9", "unixsock-stream//run/z"]), max_size=3
)


@st.composite
def components(draw: st.DrawFn) -> dict[str, Any]:
    outer = draw(st.floats(0.01, 1))
    table: dict[str, Any] = {
        "length": draw(st.floats(1e-9, 1000)),
        "outer_diameter": outer,
        "inner_diameter": outer * draw(st.floats(0, 0.99)),
    }
    kinetic = draw(from_zero)
    optional = {
        "name": draw(words),
        "shear_modulus": draw(st.floats(1e9, 1e12)),  # so that the bit is heard within 20 s
        "density": draw(st.floats(1e-9, 2e4)),
        "viscous_friction": draw(from_zero),
        "coulomb_friction": kinetic,
        "torsional_strength": draw(positive),
        "make_up_torque": draw(positive),
        "tensile_strength": draw(positive),
    }
    table |= {key: value for key, value in optional.items() if draw(st.booleans())}
    if "coulomb_friction" in table and draw(st.booleans()):
        table["static_friction"] = kinetic * draw(st.floats(1, 10))
    return table


@st.composite
def rigs(draw: st.DrawFn) -> dict[str, Any]:
    kinetic = draw(from_zero)
    gap = draw(st.floats(1e-3, 10))
    rate = draw(st.floats(1, 5000))
    tables: dict[str, Any] = {
        "top_drive": {
            "inertia": draw(from_zero),
            "gear_ratio": draw(positive),
            "efficiency": draw(st.floats(0.1, 1)),
        },
        "bit": {"kinetic_torque": kinetic, "static_torque": kinetic * 2, "stribeck_speed": draw(positive)},
        "measurement": {"torque_noise": draw(from_zero), "max_gap": gap, "restart_gap": gap * 2},
        "bus": {
            "prefix": draw(st.sampled_from(["rigs/{rig}", "field/{rig}/sensor", "ölfeld"])),
            "listen": draw(endpoints),
            "connect": draw(endpoints),
            "multicast_scouting": draw(st.booleans()),
            "zenoh_config": draw(words),
        },
        "tuning": {
            "enabled": draw(st.booleans()),
            "delay": draw(st.floats(1e-6, 0.3)),
            "friction": draw(st.floats(1e-6, 0.3)),
        },
        "recording": {"enabled": draw(st.booleans()), "folder": draw(words)},
        "view": {"history": draw(positive)},
    }
    chosen = {key: value for key, value in tables.items() if draw(st.booleans())}
    return chosen | {
        "rig": {"name": draw(st.from_regex(r"[A-Za-z0-9][A-Za-z0-9._-]{0,20}", fullmatch=True))},
        "string": draw(st.lists(components(), min_size=1, max_size=4)),
        "loop": {"rate": rate},
        "estimator": {"lag": draw(st.floats(0.001, 10.0))},
    }


@given(rigs())
def test_the_effective_configuration_reads_back_exactly(tables: dict[str, Any]) -> None:
    rig = loads(tomli_w.dumps(tables), "drawn")
    assert loads(effective_toml(rig), "recorded") == rig


@given(rigs())
def test_the_effective_configuration_leaves_no_value_to_a_default(tables: dict[str, Any]) -> None:
    rig = Rig.model_validate(tables)
    again = loads(effective_toml(rig), "recorded")
    for field in Rig.model_fields:
        value = getattr(again, field)
        for table in value if isinstance(value, tuple) else (value,):
            if table is None:  # no wellbore, which TOML tells by leaving it out
                continue
            unset = type(table).model_fields.keys() - table.model_fields_set
            assert all(getattr(table, key) is None for key in unset)


@st.composite
def surveys(draw: st.DrawFn) -> dict[str, Any]:
    depth = 0.0
    stations = []
    for _ in range(draw(st.integers(2, 5))):
        depth += draw(st.floats(0.1, 1000))
        stations.append(
            {
                "measured_depth": depth,
                "inclination": f"{draw(st.floats(0, 89))} deg",
                "azimuth": f"{draw(st.floats(-360, 360))} deg",
            }
        )
    factor = draw(st.floats(0, 0.5))
    wellbore = {"mud_density": f"{draw(st.floats(1e-3, 2.5))} g/cm^3", "friction_factor": factor}
    optional = {"static_friction_factor": factor * 1.5, "weight_on_bit": draw(from_zero)}
    wellbore |= {key: value for key, value in optional.items() if draw(st.booleans())}
    return {"survey": stations, "wellbore": wellbore}


@given(surveys())
def test_a_surveyed_well_reads_back_exactly_and_leaves_no_value_to_a_default(tables: dict[str, Any]) -> None:
    rig = loads(tomli_w.dumps(tomllib.loads(SMALL) | tables), "drawn")
    again = loads(effective_toml(rig), "recorded")
    assert again == rig
    for table in (*again.survey, again.wellbore):
        assert table is not None
        assert table.model_fields_set == type(table).model_fields.keys()


def test_a_survey_that_begins_deeper_is_tied_on_straight_down() -> None:
    stations = "\n".join(
        f'[[survey]]\nmeasured_depth = "{depth} ft"\ninclination = "{angle} deg"\nazimuth = "140°"'
        for depth, angle in ((1000, 10), (2000, 180))
    )
    wellbore = '\n[wellbore]\nmud_density = "10 lb/gal"\nfriction_factor = 0.25\nweight_on_bit = "20 klbf"'
    rig = loads(SMALL + stations + wellbore, "deviated")
    tie, first, last = rig.survey
    assert (tie.measured_depth, tie.inclination, tie.azimuth) == (0, 0, first.azimuth)
    assert first.measured_depth == pytest.approx(304.8)
    assert last.inclination == pytest.approx(math.pi)
    assert rig.wellbore is not None
    assert rig.wellbore.static_friction_factor == 0.25
    assert rig.wellbore.mud_density == pytest.approx(1198.264)
    assert rig.wellbore.weight_on_bit == pytest.approx(88964.4)


def test_the_pipe_rides_on_its_tool_joints() -> None:
    assert loads(SMALL, "small").string[0].tool_joint_diameter == pytest.approx(0.127)
    rig = loads(SMALL + 'tool_joint_diameter = "6.625 in"', "small")
    assert rig.string[0].tool_joint_diameter == pytest.approx(0.168275)


def test_text_with_units_becomes_si() -> None:
    rig = loads(SMALL, "small")
    assert rig.string[0].length == pytest.approx(304.8)
    assert rig.string[0].outer_diameter == pytest.approx(0.127)
    assert rig.prefix == "rigs/small"


def test_static_friction_is_as_kinetic_unless_given() -> None:
    kinetic = SMALL + "coulomb_friction = 3\n[bit]\nkinetic_torque = 7"
    rig = loads(kinetic, "small")
    assert rig.string[0].static_friction == 3
    assert rig.bit.static_torque == 7
    both = SMALL + "coulomb_friction = 3\nstatic_friction = 4\n[bit]\nkinetic_torque = 7\nstatic_torque = 8"
    rig = loads(both, "small")
    assert rig.string[0].static_friction == 4
    assert rig.bit.static_torque == 8


def test_a_rig_cannot_be_changed() -> None:
    rig = loads(SMALL, "small")
    with pytest.raises(ValidationError):
        rig.string[0].length = 1.0  # type: ignore[misc]  # what the test is about
    assert isinstance(rig.string[0], Component)


def test_a_file_is_read_as_its_text(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(SMALL, encoding="utf-8-sig", newline="\r\n")  # as a Windows editor saves it
    assert load(file) == loads(SMALL, "small")


@pytest.mark.parametrize("content", [b"\xff\xfe", None])
def test_a_file_that_is_no_text_is_named(tmp_path: Path, content: bytes | None) -> None:
    file = tmp_path / "rig.toml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(
        ConfigError, match=r"rig\.toml(: cannot be read: No such|, line 1: is not UTF-8: save it as)"
    ):
        load(file)


def test_what_is_far_too_large_for_a_configuration_is_not_read(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_bytes(b"#" * (MOST_BYTES - len(SMALL) - 1) + b"\n" + SMALL.encode())
    assert load(file).rig.name
    with pytest.raises(ConfigError, match=r"/dev/zero: is larger than 1 MiB, as no configuration is"):
        load(Path("/dev/zero"))


def test_relative_folders_stay_relative() -> None:
    rig = loads(SMALL + '[recording]\nfolder = "here/sessions"', "small")
    assert rig.recording.folder == Path("here/sessions")


def test_strengths_are_read_in_the_units_of_their_tables_and_may_be_left_out() -> None:
    (pipe,) = loads(SMALL, "t").string
    assert (pipe.torsional_strength, pipe.make_up_torque, pipe.tensile_strength) == (None, None, None)
    given = (
        'torsional_strength = "74.1 kft*lbf"\nmake_up_torque = "41.6 kN*m"\ntensile_strength = "712.1 klbf"'
    )
    (pipe,) = loads(SMALL + given, "t").string
    assert pipe.torsional_strength == pytest.approx(100_466, abs=1)  # 1.355818 N·m a ft·lbf
    assert pipe.make_up_torque == 41_600
    assert pipe.tensile_strength == pytest.approx(3_167_579, abs=1)  # 4.448222 N a lbf
