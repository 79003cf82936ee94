"""The rig that is not there: repeatable, true to its scenario's name, honest in its truth file."""

import csv
import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike
from typer.testing import CliRunner

from tests.daemons import wait_until
from tests.strings import BIT, COLLAR, DRIVE, PIPE, rig
from vsensor.bus import Received, SurfaceInbox, open_session
from vsensor.cli import main
from vsensor.config import Bus, effective_toml
from vsensor.errors import InputError
from vsensor.estimator.component import delay
from vsensor.estimator.forward import Controller, ForwardLine
from vsensor.estimator.sections import Floats
from vsensor.estimator.severity import severity
from vsensor.grid import NS
from vsensor.messages import SENSOR_ALIVE, SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.service.pace import Pace, Slot
from vsensor.simulate.broadcast import TRUTH_COLUMNS, broadcast
from vsensor.simulate.rig import Reading, SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

STRING = (PIPE.model_copy(update={"length": 2500.0}), COLLAR)
RIG = rig(*STRING, bit=BIT, top_drive=DRIVE, rate=50.0)
SECONDS = {Scenario.STICK_SLIP: 40, Scenario.SMOOTH: 60, Scenario.OFF_BOTTOM: 40, Scenario.CONNECTION: 90}


def readings(scenario: Scenario, seconds: float, seed: int = 1) -> list[Reading]:
    simulated = SimulatedRig(RIG, PLANS[scenario], seed)
    return [simulated.sample() for _ in range(round(seconds * RIG.loop.rate))]


@pytest.fixture(scope="module")
def played() -> dict[Scenario, list[Reading]]:
    return {scenario: readings(scenario, seconds) for scenario, seconds in SECONDS.items()}


def column(of: list[Reading], name: str, start_s: float = 0.0, end_s: float = math.inf) -> Floats:
    return np.array([getattr(reading, name) for reading in of if start_s <= reading.time_s < end_s])


def test_the_same_seed_gives_the_same_readings_and_another_does_not() -> None:
    one, again, other = (readings(Scenario.SMOOTH, 2, seed) for seed in (3, 3, 4))
    assert one == again
    assert all(a.motor_torque != b.motor_torque for a, b in zip(one, other, strict=True))


def test_readings_come_at_the_rate_of_the_loop_and_the_truth_one_travel_time_earlier() -> None:
    travel = sum(delay(part) for part in STRING)
    taken = readings(Scenario.SMOOTH, 1)
    assert [reading.time_s for reading in taken] == pytest.approx([(k + 1) / 50 for k in range(50)])
    assert [r.time_s - r.bit_time_s for r in taken] == pytest.approx([travel] * 50, abs=1e-3)


def test_in_stick_slip_the_bit_stops_and_darts_while_the_surface_hardly_knows(
    played: dict[Scenario, list[Reading]],
) -> None:
    bit = column(played[Scenario.STICK_SLIP], "bit_speed", 20)
    surface = column(played[Scenario.STICK_SLIP], "motor_speed", 20)
    assert severity(bit) > 1.2
    assert np.mean(bit == 0) > 0.2
    assert bit.max() > 2 * 8
    assert np.abs(surface - 8).max() < 1


def test_in_smooth_drilling_the_bit_turns_all_the_time(played: dict[Scenario, list[Reading]]) -> None:
    bit = column(played[Scenario.SMOOTH], "bit_speed", 30)
    assert severity(bit) < 0.7
    assert bit.mean() == pytest.approx(18, abs=0.5)
    assert column(played[Scenario.SMOOTH], "bit_torque", 30).mean() == pytest.approx(3e3, rel=0.1)


def test_off_bottom_the_bit_meets_nothing(played: dict[Scenario, list[Reading]]) -> None:
    turning = column(played[Scenario.OFF_BOTTOM], "bit_torque", 10)
    assert np.abs(turning).max() < 1
    assert column(played[Scenario.OFF_BOTTOM], "bit_speed", 30).mean() == pytest.approx(6.3, abs=0.2)


def test_a_connection_is_drilling_then_rest_then_drilling(played: dict[Scenario, list[Reading]]) -> None:
    taken = played[Scenario.CONNECTION]
    drilling, resting, again = (
        column(taken, "motor_speed", start, end) for start, end in ((20, 25), (50, 60), (80, 90))
    )
    assert drilling.mean() == pytest.approx(12, abs=1)
    assert np.abs(resting).mean() < 0.5
    assert again.mean() == pytest.approx(12, abs=1)
    on_bottom, lifted = (column(taken, "bit_torque", start, end) for start, end in ((20, 25), (30, 70)))
    assert on_bottom.mean() > 2e3
    assert np.abs(lifted).max() < 100  # lifted off the rock, its unevenness is not felt either


def test_sensors_are_as_noisy_as_configured() -> None:
    def with_noise(torque: float, speed: float) -> list[Reading]:
        noise = {"torque_noise": torque, "speed_noise": speed}
        noisy = rig(*STRING, bit=BIT, top_drive=DRIVE, rate=50.0, measurement=noise)
        simulated = SimulatedRig(noisy, PLANS[Scenario.SMOOTH], 1)
        return [simulated.sample() for _ in range(1500)]

    clean, noisy = with_noise(0, 0), with_noise(300, 0.2)
    for name, wanted in (("motor_torque", 300), ("motor_speed", 0.2)):
        noise = column(noisy, name) - column(clean, name)
        assert noise.std() == pytest.approx(wanted, rel=0.1)
        assert abs(noise.mean()) < 0.1 * wanted
    # The sensors' noise, not the string's:
    assert (column(noisy, "bit_speed") == column(clean, "bit_speed")).all()


def torques(rate: float, **drive: float) -> Floats:
    """Motor torque as read, without noise, for 20 s of stick-slip on even rock."""
    smooth = replace(PLANS[Scenario.STICK_SLIP], rock_noise=0.0)
    at = rig(*STRING, bit=BIT, top_drive=DRIVE | drive, rate=rate, measurement={"torque_noise": 0})
    simulated = SimulatedRig(at, smooth, 1)
    return np.array([simulated.sample().motor_torque for _ in range(round(20 * rate))])


def test_the_torque_reading_lags_the_motors_own() -> None:
    """A first-order lag, as that of a converter's filter."""
    prompt, late = torques(1000, torque_lag=0.0), torques(1000, torque_lag=0.1)
    read = [0.0]
    for value in prompt:
        read.append(read[-1] + (value - read[-1]) * (1 - math.exp(-1e-3 / 0.1)))
    assert late == pytest.approx(np.array(read[1:]))


@pytest.mark.parametrize("drive", [{}, {"inertia": 200.0}, {"torque_lag": 0.1}])
def test_a_motor_is_controlled_between_the_samples_too(drive: dict[str, float]) -> None:
    """What it does is no matter of how often we look. Held for a sample it would be half a sample late."""
    often, seldom = torques(1000, **drive)[19::20], torques(50, **drive)
    assert np.abs(often - seldom).max() < 0.01 * np.ptp(often)


def test_the_motor_speed_is_geared() -> None:
    geared = rig(*STRING, bit=BIT, top_drive=DRIVE | {"gear_ratio": 8.0, "efficiency": 0.9}, rate=50.0)
    one, other = SimulatedRig(RIG, PLANS[Scenario.SMOOTH], 1), SimulatedRig(geared, PLANS[Scenario.SMOOTH], 1)
    direct = np.array([one.sample()[1:3] for _ in range(2000)])
    behind = np.array([other.sample()[1:3] for _ in range(2000)])
    turning = slice(1000, None)
    assert behind[turning, 1].mean() == pytest.approx(8 * direct[turning, 1].mean(), rel=0.01)
    assert behind[turning, 0].mean() == pytest.approx(direct[turning, 0].mean() / 8 / 0.9, rel=0.02)


class Air:
    """Hears what is broadcast."""

    def __init__(self) -> None:
        self.samples: dict[str, list[Sample]] = {SURFACE_TORQUE: [], SURFACE_SPEED: []}

    def put(self, topic: str, sample: Sample) -> None:
        self.samples[topic].append(sample)


def turns(*due: int) -> Iterator[int]:
    """Slots of a loop: how many samples are due at each, then one at each for ever."""
    yield from due
    while True:
        yield 1


def test_a_broadcast_leaves_none_out_though_its_turns_come_late(tmp_path: Path) -> None:
    air = Air()
    simulated = SimulatedRig(RIG, PLANS[Scenario.SMOOTH], 5)
    done = broadcast(simulated, air.put, turns(1, 7, 1, 30), samples=60, stopped=lambda: False, truth=None)

    assert done == 60
    again = SimulatedRig(RIG, PLANS[Scenario.SMOOTH], 5)
    expected = [again.sample() for _ in range(60)]
    for topic, name in ((SURFACE_TORQUE, "motor_torque"), (SURFACE_SPEED, "motor_speed")):
        samples = air.samples[topic]
        assert [sample.sequence for sample in samples] == list(range(60))
        assert [sample.value for sample in samples] == [getattr(reading, name) for reading in expected]
        assert [b.time_ns - a.time_ns for a, b in pairwise(samples)] == [NS // 50] * 59


def test_a_broadcast_ends_when_it_is_told() -> None:
    air = Air()
    asked = iter([False, False, True])
    done = broadcast(
        SimulatedRig(RIG, PLANS[Scenario.SMOOTH], 5),
        air.put,
        turns(2, 2, 2),
        samples=0,
        stopped=lambda: next(asked),
        truth=None,
    )
    assert done == len(air.samples[SURFACE_SPEED]) == 6


def test_the_truth_file_says_what_was_true_at_the_bit_and_when(tmp_path: Path) -> None:
    air = Air()
    file = tmp_path / "truth.csv"
    simulated = SimulatedRig(RIG, PLANS[Scenario.STICK_SLIP], 2)
    broadcast(simulated, air.put, turns(), samples=500, stopped=lambda: False, truth=file)

    with file.open(encoding="utf-8", newline="") as text:
        header, *rows = csv.reader(text)
    assert tuple(header) == TRUTH_COLUMNS
    again = SimulatedRig(RIG, PLANS[Scenario.STICK_SLIP], 2)
    first_ns = air.samples[SURFACE_SPEED][0].time_ns
    assert len(rows) == 500
    for row, reading in zip(rows, (again.sample() for _ in range(500)), strict=True):
        time_s, torque, speed = map(float, row)
        since_first = reading.bit_time_s - 1 / 50
        assert time_s == pytest.approx(first_ns / NS + since_first, abs=2e-6)
        assert (torque, speed) == pytest.approx((reading.bit_torque, reading.bit_speed), abs=1e-3)


def test_a_truth_that_cannot_be_written_is_told_in_a_sentence(tmp_path: Path) -> None:
    full = tmp_path / "full.csv"
    full.symlink_to("/dev/full")
    for file, said in (
        (tmp_path / "no" / "x.csv", "No such file"),
        (tmp_path, "Is a directory"),
        (full, "No space left on device"),
    ):
        with pytest.raises(InputError, match=f"{file}: cannot be written: {said}"):
            broadcast(
                SimulatedRig(RIG, PLANS[Scenario.SMOOTH], 1),
                Air().put,
                turns(),
                samples=1,
                stopped=lambda: False,
                truth=file,
            )


@pytest.mark.parametrize("option", [("--duration", "inf"), ("--duration", "1e308"), ("--seed", "-1")])
def test_what_cannot_be_simulated_is_wrong_use(option: tuple[str, str]) -> None:
    done = CliRunner().invoke(main.app, ["simulate", "config/drilling.toml", *option])
    assert done.exit_code == 2
    assert f"Invalid value for '{option[0]}'" in done.output


def received(inbox: SurfaceInbox, count: int) -> bool:
    """Whether so many samples come, and no more."""
    got: list[Received] = []

    def all_of_them() -> bool:
        got.extend(inbox.drain())
        return len(got) >= count

    wait_until(all_of_them, f"{count} samples")
    return len(got) == count


def test_the_command_publishes_for_its_time_however_short(tmp_path: Path, bus: Bus) -> None:
    config = tmp_path / "rig.toml"
    config.write_text(effective_toml(RIG.model_copy(update={"bus": bus})), encoding="utf-8")
    with (
        open_session(bus, "daemon") as session,
        session.liveliness().declare_token(f"{RIG.prefix}/{SENSOR_ALIVE}"),
    ):
        inbox = SurfaceInbox(session, RIG.prefix, (SURFACE_TORQUE, SURFACE_SPEED))
        for duration, count in (("0.5", 25), ("0.001", 1)):
            truth = tmp_path / f"{duration}.csv"
            options = ["--scenario", "smooth", "--duration", duration, "--truth", str(truth)]
            result = CliRunner().invoke(main.app, ["simulate", str(config), *options])
            assert result.exit_code == 0, result.output
            assert f"{count} samples a channel published" in result.output
            assert len(truth.read_text(encoding="utf-8").splitlines()) == count + 1
            assert received(inbox, 2 * count)


def test_kernels_are_loaded_before_the_first_sample_is_due(
    tmp_path: Path, bus: Bus, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = tmp_path / "rig.toml"
    config.write_text(effective_toml(RIG.model_copy(update={"bus": bus})), encoding="utf-8")
    happened: list[str] = []

    class Kernel(ForwardLine):
        def control(
            self, by: Controller, set_speed: ArrayLike, bit_torque: ArrayLike
        ) -> tuple[Floats, Floats, Floats, Floats]:
            happened.append("kernel")
            return super().control(by, set_speed, bit_torque)

    class Slots(Pace):
        def slots(self) -> Iterator[Slot]:
            happened.append("slots")
            return super().slots()

    monkeypatch.setattr("vsensor.simulate.rig.ForwardLine", Kernel)
    monkeypatch.setattr("vsensor.service.pace.Pace", Slots)
    with (
        open_session(bus, "daemon") as session,
        session.liveliness().declare_token(f"{RIG.prefix}/{SENSOR_ALIVE}"),
    ):
        done = CliRunner().invoke(main.app, ["simulate", str(config), "--duration", "0.04"])
    assert done.exit_code == 0, done.output
    assert happened == ["kernel", "slots", "kernel", "kernel"]


def test_without_a_bus_the_command_says_what_to_start(tmp_path: Path, bus: Bus) -> None:
    config = tmp_path / "rig.toml"
    config.write_text(effective_toml(RIG.model_copy(update={"bus": bus})), encoding="utf-8")
    result = CliRunner().invoke(main.app, ["simulate", str(config)])
    assert result.exit_code == 1
    assert "is the daemon (vsensor run) up?" in result.output
