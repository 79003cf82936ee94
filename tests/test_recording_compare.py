"""Two runs held against one another: what changed, where and by how much."""

import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.rigs import SHORT
from vsensor.checkpoint import length_of, remembered, whole
from vsensor.cli.main import app
from vsensor.cli.overrides import changed, overridden
from vsensor.config import Rig, loads
from vsensor.errors import ConfigError
from vsensor.messages import Estimate, Tick
from vsensor.recording import compare
from vsensor.recording.compare import Change, Comparison
from vsensor.recording.reader import Session
from vsensor.service.engine import Engine
from vsensor.service.otherwise import Otherwise

GOLDEN = Path(__file__).parent.parent / "recordings" / "stick_slip.mcap"
NS = 1_000_000_000
RPM = 30 / math.pi


def estimate(number: int, speed: float, later_s: float = 0.0) -> Estimate:
    """An answer that is confirmed a second late, or later."""
    time_ns = 1000 * NS + number * NS // 100
    return Estimate(
        number=number,
        time_ns=time_ns,
        confirmed_time_ns=time_ns - NS - round(later_s * NS),
        confirmed_bit_speed_rad_s=speed,
        confirmed_bit_speed_std_rad_s=0.1,
    )


def compared(pairs: list[tuple[Estimate, Estimate]]) -> Change:
    comparison = Comparison(len(pairs))
    for pair in pairs:
        comparison.see(pair)
    comparison.finish()
    return comparison.changes[0]


def wave(number: float, later_s: float = 0.0) -> float:
    return math.sin(2 * math.pi * (number / 100 - later_s))


def test_where_and_by_how_much() -> None:
    pairs = [(estimate(n, wave(n)), estimate(n, wave(n) + (0.5 if n == 70 else 0.0))) for n in range(200)]
    change = compared(pairs)
    assert change.compared == 200
    assert change.largest == pytest.approx(0.5 * RPM)
    assert change.largest_at_s == change.first_at_s == pytest.approx(0.7 - 1.0)
    assert change.rms == pytest.approx(0.5 * RPM / math.sqrt(200))


def test_the_same_is_no_change_at_all() -> None:
    change = compared([(estimate(n, wave(n)), estimate(n, wave(n))) for n in range(300)])
    assert (change.compared, change.rms, change.largest) == (300, 0.0, 0.0)
    assert math.isnan(change.first_at_s)


@pytest.mark.parametrize("later_s", [0.25, 0.253])
def test_answers_for_the_same_moment_are_compared_though_they_come_later(later_s: float) -> None:
    pairs = [(estimate(n, wave(n)), estimate(n, wave(n, later_s), later_s)) for n in range(500)]
    assert compared(pairs).rms < 0.002 * RPM
    assert compared(pairs).compared == pytest.approx(500 - 100 * later_s, abs=2)


def test_it_makes_no_difference_in_which_blocks_they_are_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    noise = rng.standard_normal((3000, 2))
    pairs = [(estimate(n, a), estimate(n, b, 0.1)) for n, (a, b) in enumerate(noise)]
    whole = compared(pairs)
    monkeypatch.setattr(compare, "BLOCK", 300)
    monkeypatch.setattr(compare, "CARRIED", 50)
    parts = compared(pairs)
    assert (parts.compared, parts.largest, parts.largest_at_s) == (
        whole.compared,
        whole.largest,
        whole.largest_at_s,
    )
    assert parts.rms == pytest.approx(whole.rms, rel=1e-12)


@pytest.mark.parametrize("silent", ["recorded", "now"])
def test_of_a_run_that_falls_silent_nothing_is_waited_for(
    silent: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All that one answered would be held, and put in order again with each tick."""
    monkeypatch.setattr(compare, "BLOCK", 100)
    monkeypatch.setattr(compare, "CARRIED", 20)
    comparison, held = Comparison(2000), []
    for k in range(2000):
        mute = Estimate(number=k, time_ns=estimate(k, 0.0).time_ns)
        told = estimate(k, wave(k))
        spoken = 500 <= k < 800
        pair = (mute, told) if silent == "recorded" else (told, mute)
        comparison.see((told, told) if spoken else pair)
        track = comparison._tracks[0]
        held.append(len(track._recorded.rows) + len(track._now.rows))
    comparison.finish()
    change = comparison.changes[0]
    assert max(held) <= 2 * (100 + 20)
    assert change.compared >= 300
    assert change.largest == pytest.approx(0.0, abs=1e-9)


def test_a_clock_that_was_set_back_mixes_nothing() -> None:
    first = [(estimate(n, 1.0), estimate(n, 1.0)) for n in range(100)]
    second = [(estimate(n, 5.0), estimate(n, 5.0)) for n in range(100)]
    assert compared([*first, *second]).rms == 0.0


def test_a_long_session_becomes_columns_with_their_extremes() -> None:
    count = 10 * compare.COLUMNS
    pairs = [(estimate(n, wave(n)), estimate(n, wave(n) + (n == 1234))) for n in range(count)]
    shown = compared(pairs).envelope
    assert len(shown.time_s) == len(shown.change) == compare.COLUMNS
    assert max(greatest for _, greatest in shown.change) == pytest.approx(RPM)
    assert sum(greatest > 0 for _, greatest in shown.change) == 1


def recorded() -> Rig:
    return loads(Session(GOLDEN).configuration or "", "golden")


def test_values_are_set_by_their_path_with_units() -> None:
    rig = overridden(recorded(), ["string[1].length=2 km", "tuning.enabled=false", "bit.inertia=7"], "x")
    assert (rig.string[0].length, rig.tuning.enabled, rig.bit.inertia) == (2000.0, False, 7.0)
    assert changed(recorded(), rig) == [
        "string[1].length: 2500 → 2000",
        "bit.inertia: 50 → 7",
        "tuning.enabled: True → False",
    ]


@pytest.mark.parametrize(
    ("setting", "fault"),
    [
        ("bit.inertia", "write KEY=VALUE"),
        ("string[9].length=1", "no number 9: there are"),
        ("string[0].length=1", "no number 0"),
        ("bit[1].inertia=1", "this is no list"),
        ("bit.[=1", "is no key"),
        ("bit.inertia=5 m", "bit.inertia: '5 m' does not measure in kg"),
        ("bit.colour=1", "no such key"),
        ("string.length=5", "string.length: string is a list of 3: write such as string[1].length"),
        ("string.length.x=5", "string.length.x: string is a list of 3: write such as string[1].length"),
        ("top_drive.inertia.x=1", "top_drive.inertia.x: top_drive.inertia is a value and has no x"),
        ("rig.name.x=1", "rig.name.x: rig.name is a value and has no x"),
        ("rig.name.x.y=1", "rig.name.x.y: rig.name is a value and has no x"),
    ],
)
def test_what_cannot_be_set_is_named(setting: str, fault: str) -> None:
    with pytest.raises(ConfigError, match=f"(?s){fault.replace('[', '.').replace(']', '.')}"):
        overridden(recorded(), [setting], "x")


def run(*words: str) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["verify", str(GOLDEN), *words])
    return done.exit_code, done.output


def lengthen(sensor: Engine, metres: float) -> None:
    """Add pipe, which the next tick takes up."""
    sensor.intake.depths.lengthen(metres)
    longer_by = sensor.intake.depths.longer_by()
    sensor.step(Tick(number=1, motor_torque_nm=1e3, motor_speed_rad_s=9.0, longer_by_m=longer_by))


def test_of_another_strings_state_only_what_was_added_is_taken_up() -> None:
    """A later part of a recording, run under a string of another length."""
    recording, unchanged = Otherwise(SHORT, SHORT), Otherwise(SHORT, SHORT)
    lengthen(recording, 28.5)
    state = whole(*remembered(recording.intake, recording.estimator))
    unchanged.take_up(state)
    assert unchanged.estimator.string[0].length == 1228.5

    other = Otherwise(overridden(SHORT, ["string[1].length=1300"], "x"), SHORT)
    with pytest.raises(ValueError, match="it is of the recorded string"):
        other.take_up(state)
    assert other.estimator.string[0].length == 1328.5

    lengthen(recording, 28.5)
    for later in (state, whole(*remembered(recording.intake, recording.estimator)), state):
        longer = length_of(later) - 1200.0
        with pytest.raises(ValueError, match="it is of the recorded string"):
            other.take_up(later)
        assert other.estimator.string[0].length == 1300.0 + longer


def test_a_picture_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "full.png").symlink_to("/dev/full")
    status, said = run("-o", str(tmp_path / "full.png"))
    assert status == 1
    assert "full.png: cannot be written: No space left on device" in said


def test_under_another_rig_it_tells_and_draws_what_changes(tmp_path: Path) -> None:
    picture = tmp_path / "changes.png"
    status, said = run("--set", "top_drive.inertia=2100 kg*m^2", "-o", str(picture))
    assert status == 0
    assert "under top_drive.inertia: 2000 → 2100" in said
    assert "confirmed bit speed" in said
    assert "forecast bit torque" in said
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_several_sessions_are_verified_at_once_and_other_rates_refused(tmp_path: Path) -> None:
    status, said = run(str(GOLDEN), "--set", "bus.multicast_scouting=true")
    assert (status, said.count("exact: ")) == (0, 2)
    assert run("--set", "loop.rate=50 Hz")[0] == 2
    assert run(str(GOLDEN), "-o", str(tmp_path / "a.png"))[0] == 2
    assert run("-o", str(tmp_path / "a.gif"))[0] == 2
    status, said = run("-o", str(tmp_path / "nowhere" / "a.png"))
    assert (status, "exact" in said) == (2, False)
    assert "there is no folder" in said
