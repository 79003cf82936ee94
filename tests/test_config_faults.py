"""Every fault of a configuration is told at once: where it is, what it says, what would be right."""

import pytest
import tomli_w
from hypothesis import given
from hypothesis import strategies as st

from vsensor.config import loads
from vsensor.errors import ConfigError

RIG = '[rig]\nname = "x"\n'
PIPE = '[[string]]\nlength = "9 m"\nouter_diameter = "5 in"\ninner_diameter = "4 in"\n'

WELLBORE = "[wellbore]\nmud_density = 1200\nfriction_factor = 0.25\n"


def survey(*stations: tuple[float, float, float]) -> str:
    """Stations of measured depth (m), inclination and azimuth (deg)."""
    return "".join(
        f'[[survey]]\nmeasured_depth = {depth}\ninclination = "{angle} deg"\nazimuth = "{azimuth} deg"\n'
        for depth, angle, azimuth in stations
    )


WELL = survey((0, 0, 0), (1000, 30, 140)) + WELLBORE


def faults(text: str) -> list[str]:
    with pytest.raises(ConfigError) as refusal:
        loads(text, "rig.toml")
    head, *lines = str(refusal.value).split("\n")
    assert head.startswith("rig.toml: ")
    return [line.strip() for line in lines] or [head]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (PIPE, 'rig: is missing: write [rig] with a name, such as name = "well-b"'),
        (RIG, "string: is missing: write one [[string]] table for each component, from the top drive down"),
        ("string = []\n" + RIG, "string = []: must not be empty: write one [[string]] table"),
        ("string = 5\n" + RIG, "string = 5: must be a list: write one [[string]] table"),
        ('[rig]\nname = "well b"\n' + PIPE, "rig.name = 'well b': cannot be used: write letters, digits"),
        (RIG + PIPE + 'name = ""', "string[1].name = '': must not be empty"),
        (
            RIG + PIPE + 'outer_diamter = "5 in"',
            "string[1].outer_diamter: no such key: did you mean outer_diameter?",
        ),
        (RIG + PIPE + "[loop]\ncolour = 1", "loop.colour: no such key: known here are rate"),
        (
            RIG + PIPE + '[recording]\nfolder = "re\\u0000c"',
            "recording.folder: 're\\x00c' is no path: no file's name holds a zero",
        ),
        (RIG + PIPE + "[loops]", "loops: no such key: did you mean loop?"),
        (RIG + PIPE + 'density = "-1 kg/m³"', "string[1].density = '-1 kg/m³': must be greater than 0"),
        (
            RIG + PIPE + 'density = "1 m"',
            "string[1].density: '1 m' does not measure in kg/m^3: write for example",
        ),
        (RIG + PIPE + "density = inf", "string[1].density: inf is not finite"),
        (
            RIG + PIPE.replace("9 m", "200 km"),
            "string: a wave takes 62.9 s to reach the bit, and none is told of that takes more than 20 s",
        ),
        (
            RIG + 2 * PIPE + 'shear_modulus = "79.3 Pa"',
            "string: a wave takes 89.5 s to reach the bit",
        ),
        (
            RIG + PIPE + '[top_drive]\ntorque_lag = "1 h"',
            "top_drive.torque_lag = '1 h': must be at most 10: write",
        ),
        (
            RIG + PIPE + "static_friction = 1\ncoulomb_friction = 2",
            "string[1]: static_friction 1 N·m/m must be at",
        ),
        (
            RIG + PIPE.replace("4 in", "6 in"),
            "string[1]: inner_diameter 0.1524 m must be smaller than outer_",
        ),
        (
            RIG + PIPE + "[top_drive]\nefficiency = 1.2",
            "top_drive.efficiency = 1.2: must be at most 1: write",
        ),
        (
            RIG + PIPE + "[top_drive]\ngear_ratio = '8'",
            "top_drive.gear_ratio = '8': must be a number, without quotes",
        ),
        (
            RIG + PIPE + "[top_drive]\ngear_ratio = nan",
            "top_drive.gear_ratio = nan: must be finite: write motor turns",
        ),
        (RIG + PIPE + "[top_drive]\ninertia = true", "top_drive.inertia: True is no quantity"),
        (
            RIG + PIPE + "[bit]\nstatic_torque = 1\nkinetic_torque = 2",
            "bit: static_torque 1 N·m must be at least",
        ),
        (RIG + PIPE + "[measurement]\nmax_gap = 3", "measurement: restart_gap 2 s must exceed max_gap 3 s"),
        (
            RIG + PIPE + '[loop]\nrate = "9 kHz"',
            "loop.rate = '9 kHz': must be at most 5000: write a rate from",
        ),
        (
            RIG + PIPE + '[estimator]\nlag = "11 s"',
            "estimator.lag = '11 s': must be at most 10: write a time",
        ),
        (RIG + PIPE + "[estimator]\nlag = 0", "estimator.lag = 0: must be greater than 0: write a time"),
        (RIG + PIPE + "[estimator]\nbandwidth = 3", "estimator.bandwidth"),
        (RIG + PIPE + "[tuning]\ndelay = 0.5", "tuning.delay = 0.5: must be at most 0.3: write a share"),
        (RIG + PIPE + "[tuning]\ninertia = 0", "tuning.inertia = 0: must be greater than 0: write a share"),
        (RIG + PIPE + '[tuning]\nfriction = "15 %"', "tuning.friction = '15 %': "),
        (RIG + PIPE + "[tuning]\nenabled = 1", "tuning.enabled = 1: must be true or false"),
        (RIG + PIPE + '[bus]\nprefix = "/x"', "bus.prefix = '/x': cannot be used: write words"),
        (RIG + PIPE + '[bus]\nprefix = "a//x"', "bus.prefix = 'a//x': cannot be used: write words"),
        (
            RIG + PIPE + '[bus]\nlisten = ["localhost"]',
            "bus.listen[1] = 'localhost': cannot be used: write endpoints",
        ),
        (
            RIG + PIPE + '[bus]\nconnect = "tcp/a:1"',
            "bus.connect = 'tcp/a:1': must be a list: write endpoints",
        ),
        (
            RIG + PIPE + '[recording]\nenabled = "no"',
            "recording.enabled = 'no': must be true or false, without",
        ),
        (
            RIG + PIPE + '[recording]\ncompression = "zip"',
            "recording.compression = 'zip': must be 'zstd', 'lz4' or",
        ),
        ("view = 5\n" + RIG + PIPE, "view = 5: must be a table"),
        ("length = \n", "rig.toml: not valid TOML: Invalid value (at line 1, column 10)"),
        ("a = " + "[" * 5000, "rig.toml: not valid TOML: "),
        ("a = " + "1" * 5000, "rig.toml: not valid TOML: "),
    ],
)
def test_a_fault_says_where_and_what_would_be_right(text: str, fault: str) -> None:
    told = faults(text)
    assert len(told) == 1
    assert told[0].startswith(fault)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            RIG + PIPE + 'tool_joint_diameter = "4.5 in"',
            "string[1]: tool_joint_diameter 0.1143 m must be at least outer_diameter 0.127 m",
        ),
        (
            RIG + PIPE + 'tool_joint_bore = "5 in"',
            "string[1]: tool_joint_bore 0.127 m must be smaller than tool_joint_diameter 0.127 m",
        ),
        (
            RIG + PIPE + 'tool_joint_length = "32 ft"',
            "string[1]: tool_joint_length 9.7536 m must be less than joint_length 9.45 m",
        ),
        (RIG + PIPE + survey((9, 0, 0)) + WELLBORE, "survey: one station makes no path: write two or more"),
        (
            RIG + PIPE + survey((0, 0, 0), (900, 9, 0), (900, 12, 0)) + WELLBORE,
            "survey: the station at 900 m must be deeper than the one before it, at 900 m",
        ),
        (
            RIG + PIPE + survey((0, 0, 0), (900, 60, 10), (990, 120, 190)) + WELLBORE,
            "survey: the well points the other way at 990 m than at 900 m",
        ),
        (
            RIG + PIPE + survey((900, 180, 10), (990, 120, 10)) + WELLBORE,
            "survey: the well points the other way at 900 m than at 0 m",
        ),
        (
            RIG + PIPE + survey((-1, 0, 0), (9, 0, 0)) + WELLBORE,
            "survey[1].measured_depth = -1: must be at least 0: write a length along the well",
        ),
        (
            RIG + PIPE + survey((0, 0, 0), (900, 181, 0)) + WELLBORE,
            "survey[2].inclination = '181 deg': must be at most 3.14159: write an angle from",
        ),
        (
            RIG + PIPE + survey((0, 0, 0), (900, -1, 0)) + WELLBORE,
            "survey[2].inclination = '-1 deg': must be at least 0: write an angle from",
        ),
        (
            RIG + PIPE + WELL.replace('"140 deg"', "140"),  # degrees meant, radians said
            "survey[2].azimuth = 140: must be at most 6.28319: write an angle from",
        ),
        (
            RIG + PIPE + WELL.replace("140 deg", "140 m"),
            "survey[2].azimuth: '140 m' does not measure in rad: write for example",
        ),
        (RIG + PIPE + survey((0, 0, 0), (9, 0, 0)), "survey and wellbore need one another: write [wellbore]"),
        (RIG + PIPE + WELLBORE, "survey and wellbore need one another: write [[survey]] tables too"),
        (RIG + PIPE + WELL.replace("mud_density = 1200", ""), "wellbore.mud_density: is missing: write a"),
        (
            RIG + PIPE + WELL.replace("1200", '"9 ft"'),
            "wellbore.mud_density: '9 ft' does not measure in kg/m^3",
        ),
        (
            RIG + PIPE + PIPE + WELL.replace("1200", '"7.9 g/cm³"'),
            'wellbore.mud_density 7900 kg/m³ must be below the 7850 kg/m³ of string[1] "pipe"',
        ),
        (
            RIG + PIPE + WELL.replace("0.25", '"0.25"'),
            "wellbore.friction_factor = '0.25': must be a number, without quotes: write a kinetic",
        ),
        (
            RIG + PIPE + WELL + "static_friction_factor = 0.2",
            "wellbore: static_friction_factor 0.2 must be at least friction_factor (kinetic) 0.25",
        ),
        (
            RIG + PIPE + WELL + 'weight_on_bit = "8 t"',
            "wellbore.weight_on_bit: '8 t' does not measure in N: write for example",
        ),
        (
            RIG + PIPE + PIPE + 'name = "collar"\ncoulomb_friction = 1\n' + WELL,
            'string[2] "collar": coulomb_friction and static_friction are an alternative to a survey',
        ),
        (
            RIG + PIPE + "static_friction = 1\n" + WELL,
            'string[1] "pipe": coulomb_friction and static_friction are an alternative to a survey',
        ),
    ],
)
def test_a_fault_of_the_well_says_where_and_what_would_be_right(text: str, fault: str) -> None:
    (told,) = faults(text)
    assert told.startswith(fault)


def test_all_faults_are_told_at_once() -> None:
    told = faults("[rig]\n[[string]]\nlength = 0\nbore = 1\n[bit]\ninertia = 'x'\n[view]\nhistory = 0\n")
    assert [line.split(":")[0] for line in told] == [
        "rig.name",
        "string[1].length = 0",
        "string[1].outer_diameter",
        "string[1].inner_diameter",
        "string[1].bore",
        "bit.inertia",
        "view.history = 0",
    ]


def test_a_fault_is_told_once_though_others_follow_from_it() -> None:
    text = RIG + PIPE + 'coulomb_friction = "much"\n[bit]\nkinetic_torque = "much"'
    assert [line.split(":")[0] for line in faults(text)] == [
        "string[1].coulomb_friction",
        "bit.kinetic_torque",
    ]


def test_a_long_value_is_cut_short() -> None:
    assert len(faults(RIG + PIPE + f'[recording]\ncompression = "{"z" * 1000}"')[0]) < 200


@given(st.text())
def test_any_text_is_a_configuration_or_a_config_error(text: str) -> None:
    with pytest.raises(ConfigError):
        loads(text, "any")


scalars = st.one_of(st.booleans(), st.integers(), st.floats(), st.text(max_size=5))
keys = st.sampled_from(
    ["name", "length", "azimuth", "inertia", "rate", "listen", "folder", "zenoh_config", "history", "odd"]
)
tables = st.dictionaries(keys, st.one_of(scalars, st.lists(scalars, max_size=2)), max_size=3)
sections = st.sampled_from(
    ["rig", "string", "survey", "wellbore", "top_drive", "bit", "bus", "recording", "view", "loop", "odd"]
)


@given(
    st.dictionaries(sections, st.one_of(scalars, tables, st.lists(st.one_of(scalars, tables), max_size=2)))
)
def test_whatever_stands_in_a_table_is_told_in_our_words(data: dict[str, object]) -> None:
    told = faults(tomli_w.dumps(data))
    assert all(line and "Input should" not in line for line in told)
