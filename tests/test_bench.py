"""The benchmarks: each runs at a tiny size and keeps honest books. No speed is asserted."""

import json
import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from typer.testing import CliRunner

from vsensor.bench import (
    day,
    kernel,
    live,
    loads,
    offline,
    reading,
    seen,
    served,
    stage,
    tick,
    turns,
    view,
    wakes,
)
from vsensor.bench.compiler import FLAGS, NO_COMPILER, compiler
from vsensor.bench.processes import child_of, processor_s
from vsensor.bench.record import drilled, endless
from vsensor.bench.rounds import LEAST_ROUNDS, alternate
from vsensor.bench.table import Table
from vsensor.bench.well import deep_well
from vsensor.cli import main
from vsensor.config import load
from vsensor.demo import example
from vsensor.errors import ConfigError, VsensorError
from vsensor.estimator.estimator import Estimator
from vsensor.estimator.kernel import CONFIRMED
from vsensor.grid import NS
from vsensor.intake import Intake
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample, Status, Tick
from vsensor.service.histogram import quantile_s
from vsensor.view.batches import Measured
from vsensor.view.sink import send

needs_c = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
SHORT_S = 0.01


@pytest.fixture(scope="module")
def case() -> kernel.Case:
    return kernel.deep_case()


def rows(table: Table) -> list[dict[str, object]]:
    told = table.as_dict()["rows"]
    assert isinstance(told, list)
    return told


def test_contestants_take_turns_and_the_order_turns_round() -> None:
    order: list[str] = []
    taken = alternate({"a": lambda: order.append("a"), "b": lambda: order.append("b")}, 0)
    assert order == list("ab" + "abba" * (LEAST_ROUNDS // 2) + "ab" * (LEAST_ROUNDS % 2))
    assert all(0 < times.least <= times.median for times in taken.values())


@needs_c
def test_the_kernels_are_held_against_c_that_says_the_same() -> None:
    (table,) = kernel.tables(SHORT_S)
    told = rows(table)
    assert [row["kernel"] for row in told] == [
        *["march, a section"] * 3,
        *["observer's step, a section"] * 3,
        *["correction, a number"] * 3,
    ]
    for own in (0, 3, 6):
        assert told[own]["ours / this"] is None
        for row, flags in zip(told[own + 1 : own + 3], FLAGS, strict=True):
            assert row["made by"] == f"C, {flags}"
            assert row["ours / this"] == pytest.approx(told[own]["median, ns"] / row["median, ns"])  # type: ignore[operator]


def test_without_a_compiler_there_is_no_ratio_and_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    (table,) = kernel.tables(SHORT_S)
    assert [row["made by"] for row in rows(table)] == ["ours (numba)"] * 3
    assert NO_COMPILER in table.notes


def test_c_that_says_something_else_is_no_yardstick(case: kernel.Case) -> None:
    ours, other = kernel._ours(case), kernel._ours(case)
    for contestant in (ours, other):
        kernel.run_once(contestant)
    kernel.check(other.state, ours.state, "-O9")
    other.state.told[0, 1, 7] *= 1 + 1e-9
    with pytest.raises(VsensorError, match=r"-O9.*differ in told by"):
        kernel.check(other.state, ours.state, "-O9")
    other.state.told[0, 1, 7] = np.nan
    with pytest.raises(VsensorError, match="differ in told by nan"):
        kernel.check(other.state, ours.state, "-O9")


def test_what_is_compared_was_worked_out(case: kernel.Case) -> None:
    ours = kernel._ours(case)
    kernel.run_once(ours)
    for name in kernel.COMPARED:
        assert not np.array_equal(getattr(ours.state, name), getattr(case.state, name)), name


def test_junctions_of_a_march_are_counted_as_it_meets_them(case: kernel.Case) -> None:
    trips, reach = case.model.line.round_trip, kernel.march_steps(case.model)
    last = len(trips) - 1
    count = highest = 0
    matters = reach - trips[1:].sum()
    for ahead in range(1, reach + 1):
        while ahead > matters and highest < last:
            highest += 1
            matters += trips[highest]
        count += 1 + last - highest
    assert kernel.junctions_marched(case) == count


def test_a_tick_is_timed_at_each_rate() -> None:
    (table,) = tick.tables(SHORT_S, (20.0, 50.0))
    for row, rate in zip(rows(table), (20.0, 50.0), strict=True):
        assert row["rate, Hz"] == rate
        called = row["as the daemon calls it, µs"]
        assert isinstance(called, float)
        assert row["of its time, %"] == pytest.approx(called * rate / 1e4)


@pytest.mark.parametrize("part", [tick.CONFIRMED, tick.TUNED])
def test_the_confirmed_answer_alone_is_the_same_answer(part: int) -> None:
    rate = 10.0
    rig = deep_well(rate)
    torque, speed = drilled(rig, round((Estimator(rig).warm_up + 3) * rate))
    assert np.ptp(speed) > 1
    whole, alone = Estimator(rig).run(torque, speed).values, tick.Part(rig, part).run(torque, speed)
    known = np.isfinite(whole[:, CONFIRMED])
    assert known[-1]
    np.testing.assert_array_equal(whole[known][:, [CONFIRMED, CONFIRMED + 2]], alone[known])


def test_of_what_is_sent_over_and_over_no_sample_is_refused() -> None:
    rig = live.rig_at(100.0)
    intake = Intake(rig)
    torque, speed = (np.tile(once, 3).tolist() for once in endless(rig))
    for k, pair in enumerate(zip(torque, speed, strict=True)):
        for topic, value in zip((SURFACE_TORQUE, SURFACE_SPEED), pair, strict=True):
            intake.take(topic, Sample(time_ns=NS + k * NS // 100, value=value, sequence=k))
    for channel in intake.channels.values():
        assert channel.counts.accepted == channel.counts.received == 3000


def test_offline_every_row_becomes_a_tick() -> None:
    (table,) = offline.tables(SHORT_S)
    assert "720 rows gave 1440 samples accepted and 720 ticks" in table.notes
    took = {row["stage"]: row["seconds"] for row in rows(table)}
    assert all(isinstance(seconds, float) and seconds >= 0 for seconds in took.values())
    assert rows(table)[3]["times the estimator"] == 1


def test_a_day_is_told_of_whole_commands_and_one_that_fails_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    told = {"samples to Parquet": ("export", "--surface")}
    monkeypatch.setattr(day, "COMMANDS", told)
    monkeypatch.setattr(day, "TURNS", 1)
    (table,) = day.tables(SHORT_S, lambda _: None)
    (row,) = rows(table)
    shorter, longer, resident = (row[name] for name in ("2 s, s", "7 s, s", "memory at most, MB"))
    assert isinstance(shorter, float)
    assert isinstance(longer, float)
    assert isinstance(resident, float)
    assert min(shorter, longer) > 0.1
    assert 50 < resident < 2000
    monkeypatch.setattr(day, "COMMANDS", {"nothing": ("export", "--no-such-option")})
    with pytest.raises(VsensorError, match=r"vsensor export .* ended with 2: [\s\S]*no-such-option"):
        list(day.tables(SHORT_S, lambda _: None))


def test_both_readers_read_the_same_sessions() -> None:
    read, costs = reading.tables(0.1)
    assert [row["compression"] for row in rows(costs)] == ["none", "lz4", "zstd"]
    assert {row["what"] for row in rows(read)} == set(reading.WANTED)
    for row in rows(read):
        ours, theirs = row["by columns, µs"], row["by the library, µs"]
        assert isinstance(ours, float)
        assert isinstance(theirs, float)
        assert row["times faster"] == pytest.approx(theirs / ours)


def test_what_the_readers_do_not_agree_on_is_no_benchmark(monkeypatch: pytest.MonkeyPatch) -> None:
    real = reading.by_library
    monkeypatch.setattr(
        reading, "by_library", lambda *given: {key: column + 1 for key, column in real(*given).items()}
    )
    with pytest.raises(VsensorError, match=r"none\.mcap: time_ns of surface/torque is not what"):
        list(reading.tables(0.1))


def test_a_record_that_is_told_over_and_over_has_nothing_to_be_refused() -> None:
    table = offline.surface_table(load(example("drilling.toml")), 3002)
    assert len(table.time_s) == 3002
    assert np.diff(table.time_s).min() > 0
    assert table.motor_torque_nm[3001] == table.motor_torque_nm[1] != table.motor_torque_nm[0]
    (told,) = offline.tables(3002 / 100 / offline.SPEED_UP)
    assert "3002 rows gave 6004 samples accepted and 3002 ticks" in told.notes


def test_several_ticks_of_one_slot_are_one_turn() -> None:
    ticks = [Tick(slot=slot, lateness_ns=late) for slot, late in ((7, 50_000), (7, 50_000), (9, 90_000))]
    woken = wakes.of_ticks(ticks, 3, 1)
    assert woken.lateness_ns.tolist() == [50_000, 90_000]
    assert woken.percentile_us(100) == 90
    assert (woken.due, woken.skipped) == (3, 1)


@needs_c
@pytest.mark.process
def test_the_bare_loop_keeps_books_of_every_slot(tmp_path: Path) -> None:
    cc = compiler()
    assert cc
    with wakes.bare_loop(wakes.build_bare_loop(cc, tmp_path), 200.0, 0.1) as wait:
        woken = wait()
    assert len(woken.lateness_ns) + woken.skipped == woken.due <= 20
    assert woken.lateness_ns.min() >= 0


@needs_c
@pytest.mark.process
def test_a_bare_loop_that_failed_is_no_yardstick(tmp_path: Path) -> None:
    cc = compiler()
    assert cc
    with (
        wakes.bare_loop(wakes.build_bare_loop(cc, tmp_path), 200.0, 0.0) as wait,
        pytest.raises(VsensorError, match="bare loop"),
    ):
        wait()


@pytest.mark.process
def test_a_process_is_known_by_its_parent() -> None:
    command = ["sh", "-c", "sleep 60 & echo $!; wait"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as shell:
        assert shell.stdout
        sleeper = int(shell.stdout.readline())
        assert child_of(shell.pid) == sleeper
        with pytest.raises(VsensorError, match=f"process {sleeper} has 0 children"):
            child_of(sleeper)
        os.kill(sleeper, 15)
    assert processor_s(os.getpid()) > 0
    assert processor_s(shell.pid) == 0


@pytest.mark.process
def test_live_every_sample_is_consumed_recorded_and_made_a_tick_of(tmp_path: Path) -> None:
    run = stage.run(live.rig_at(50.0), tmp_path, 3.0, None)
    assert run.published == 400
    book = live.book(run)
    assert {book[f"samples {what}"] for what in ("published", "consumed", "recorded")} == {400}
    assert {book[what] for what in ("ticks due", "ticks run", "estimates recorded")} == {200}
    assert book["samples lost"] == book["messages not recorded"] == 0
    assert 0 < len(run.daemon.lateness_ns) <= run.daemon.due
    assert run.daemon.lateness_ns.min() >= 0
    assert 0 <= run.processor.recorder + run.processor.daemon <= 2 * run.processor.wall


@pytest.mark.process
def test_under_a_load_lateness_and_latency_stand_beside_their_yardsticks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(loads, "LOADS", (turns.LOADS[1],))
    monkeypatch.setattr(turns, "WARM_S", 1.0)
    monkeypatch.setattr(turns, "TURN_S", 0.5)
    lateness, latency, cost = map(rows, loads.tables([50.0], 1.5, lambda _words: None))
    for table in (lateness, latency, cost):
        assert [row["loop and load"] for row in table] == ["50 Hz, recording"]
    (row,) = latency
    for figure in ("whole, µs", "behind the wake-up, µs", "echo, µs"):
        told = row[figure]
        assert isinstance(told, float)
        assert told > 0
    (row,) = lateness
    median, worst, memory = row["median, µs"], row["99 %, µs"], cost[0]["memory, MB"]
    assert isinstance(median, float)
    assert isinstance(worst, float)
    assert isinstance(memory, float)
    assert 0 < median <= worst
    assert memory > 10
    assert isinstance(cost[0]["slope, kB/min"], float)


def test_daemon_and_bare_loop_run_in_turn_and_their_books_are_added_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    order: list[str] = []

    def turn(*_given: object) -> turns.Turn:
        order.append("daemon")
        before, after = Status(slots_due=100), Status(slots_due=150, slots_skipped=2)
        before.lateness.counts.extend([7, 0])
        after.lateness.counts.extend([7, 48])
        return turns.Turn(before, after, {"echo": [1.0, 2.0]}, 0.25, (60.0 * len(order), 10**8))

    @contextmanager
    def bare_loop(*_given: object) -> Iterator[Callable[[], wakes.Wakes]]:
        order.append("C")
        yield lambda: wakes.Wakes(np.full(49, 5000), 50, 1)

    monkeypatch.setattr(turns, "_turn", turn)
    monkeypatch.setattr(turns, "bare_loop", bare_loop)
    sensor = turns.Sensor(live.rig_at(50.0), 0, 0.0, None, dict)  # type: ignore[arg-type]
    found = turns._measure(sensor, turns.LOADS[0], Path("wake"), 3 * turns.TURN_S)
    assert order == ["daemon", "C"] * 3
    assert (found.due, found.skipped, len(found.memory)) == (150, 6, 3)
    assert found.latency == {"echo": [1.0, 2.0] * 3}
    assert found.bare is not None
    assert (found.bare.due, found.bare.skipped, len(found.bare.lateness_ns)) == (150, 3, 147)
    assert quantile_s([0, 1], 0.5) == found.lateness_s[0]


@pytest.mark.process
def test_the_view_is_timed_to_a_viewer_and_the_loop_without_and_with_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(view, "PAIRS", 1)
    monkeypatch.setattr(view, "WARM_S", 1.0)
    cost, lateness = map(rows, view.tables([50.0], 2.0, lambda _words: None))
    (row,) = cost
    figures = [
        row[name] for name in ("view, % of one core", "memory, MB", "median, ms", "99 %, ms", "worst, ms")
    ]
    assert all(isinstance(figure, float) and figure > 0 for figure in figures)
    median, late, worst = figures[2:]
    assert median <= late <= worst  # type: ignore[operator]
    one, both = lateness
    assert one["ratio"] == both["ratio"] == one["with, µs"] / one["without, µs"]  # type: ignore[operator]


def test_when_an_estimate_was_at_a_viewer_is_told_by_the_first_that_holds_it_or_a_later_one(
    tmp_path: Path,
) -> None:
    file = tmp_path / "seen.rrd"
    looks = served.Onlooker(file)
    recording = rr.RecordingStream("t")
    recording.set_sinks(rr.FileSink(file, write_footer=False))
    noted: list[tuple[int, int]] = []
    for number in range(40):
        entity = seen.DRAWN if number % 4 else "/elsewhere"
        times = np.array([1000 * number], dtype=np.int64)
        send(Measured(entity, times, np.ones(1), np.ones(1)), recording)
        recording.flush()
        looks.look()
        noted.append((looks.growths[-1].at_ns, 1000 * number))
    published = [(at_ns - 5, time_ns) for at_ns, time_ns in noted]
    waited = [noted[number + (number % 4 == 0)][0] - published[number][0] for number in range(40)]
    assert seen.delays_ns(published, looks).tolist() == waited
    with file.open("r+b") as torn:  # as by one who is still writing
        torn.truncate(file.stat().st_size - 9)
    assert len(seen.delays_ns(published, looks)) == 39
    assert len(seen.delays_ns([(0, 40_000)], looks)) == 0


def test_an_impossible_rate_is_refused_before_anything_runs() -> None:
    with pytest.raises(ConfigError, match=r"--rate 0\.5[\s\S]*loop\.rate"):
        next(live.tables(1.0, [100.0, 0.5], pytest.fail))


def test_the_command_prints_and_writes_its_figures(tmp_path: Path) -> None:
    file = tmp_path / "figures.json"
    arguments = ["bench", "kernel", "--seconds", "0.01", "--rate", "20", "--json", str(file)]
    result = CliRunner().invoke(main.app, arguments)
    assert result.exit_code == 0, result.output
    assert "march" in result.output
    figures = json.loads(file.read_text(encoding="utf-8"))
    assert figures["machine"]["cores"] == str(os.cpu_count())
    kernels, ticks = figures["tables"]
    assert kernels["rows"][0]["median, ns"] > 0
    assert [row["rate, Hz"] for row in ticks["rows"]] == [20.0]


@pytest.mark.parametrize(
    "arguments", [["all"], ["--rate", "0.5"], ["--seconds", "0"], ["--json", "no-such-folder/x.json"]]
)
def test_wrong_use_of_the_command_is_status_2(arguments: list[str]) -> None:
    assert CliRunner().invoke(main.app, ["bench", *arguments]).exit_code == 2
