"""What was learned outlives the daemon: whole or as it was before, and only for the same string."""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.daemons import daemon, post, wait_until
from tests.rigs import SHORT, samples, simulated
from tests.strings import PIPE
from vsensor.bus import command
from vsensor.cli import main
from vsensor.config import Bus, Rig
from vsensor.learned import begin_with, learned
from vsensor.messages import SENSOR_EVENT, Event, Learned
from vsensor.recording.reader import Session
from vsensor.service.engine import Engine
from vsensor.service.keeper import Keeper, path_of, take_up, write_whole

FEED = samples(simulated(20))


@pytest.fixture(scope="module")
def engine() -> Engine:
    """One that has drilled for a while, and whose string has become longer."""
    engine = Engine(SHORT)
    for number, (topic, sample) in enumerate(FEED):
        if number == 800:
            engine.intake.depths.lengthen(28.5)
        list(engine.take(topic, sample))
    return engine


@pytest.fixture(scope="module")
def kept(engine: Engine) -> Learned:
    return Learned.FromString(learned(SHORT, engine.intake, engine.estimator).SerializeToString())


def test_law_corrections_and_length_are_taken_up(engine: Engine, kept: Learned) -> None:
    other = Engine(SHORT)
    assert other.estimator.law != engine.estimator.law
    begin_with(kept, SHORT, other.intake, other.estimator)
    assert other.estimator.law == engine.estimator.law
    assert other.estimator.tuning.tolist() == engine.estimator.tuning.tolist()
    assert other.estimator.rock_std == engine.estimator.rock_std
    assert other.intake.depths.length == engine.intake.depths.length == 1200 + 28.5
    assert other.estimator.string == engine.estimator.string
    assert len(kept.SerializeToString()) < 20_000


def test_it_answers_sooner_and_its_first_answers_are_the_law_s(kept: Learned) -> None:
    """Now and forecast need their own record before they are told: it is taken up too."""
    fresh, other = Engine(SHORT), Engine(SHORT)
    begin_with(kept, SHORT, other.intake, other.estimator)
    first = []
    for each in (fresh, other):
        told = [e for topic, sample in FEED for _, e in each.take(topic, sample)]
        first.append(next(n for n, e in enumerate(told) if e.HasField("now_bit_speed_rad_s")))
    assert first[1] < first[0]


def foreign(**update: object) -> Rig:
    return SHORT.model_copy(update=update)


@pytest.mark.parametrize(
    ("rig", "why"),
    [
        (foreign(string=(PIPE,)), "string"),
        (foreign(loop=SHORT.loop.model_copy(update={"rate": 25.0})), r"loop\.rate"),
        (foreign(bit=SHORT.bit.model_copy(update={"inertia": 60.0})), "bit"),
        (foreign(rig=Rig.Name(name="other")), "'test'"),
    ],
    ids=["string", "rate", "bit", "rig"],
)
def test_what_another_string_taught_is_refused_by_what_differs(kept: Learned, rig: Rig, why: str) -> None:
    other = Engine(rig)
    before = other.estimator.learned()
    with pytest.raises(ValueError, match=why):
        begin_with(kept, rig, other.intake, other.estimator)
    after = other.estimator.learned()
    assert all(np.array_equal(before[name], after[name]) for name in before)


def test_what_does_not_matter_to_the_estimator_may_change(kept: Learned) -> None:
    other = foreign(view=SHORT.view.model_copy(update={"history": 5.0}))
    engine = Engine(other)
    begin_with(kept, other, engine.intake, engine.estimator)


@pytest.mark.parametrize(
    "damage", ["cut", "garbage", "nan", "version", "huge", "no kind of number", "too long", "no length"]
)
def test_a_damaged_file_is_put_aside_and_all_begins_anew(kept: Learned, tmp_path: Path, damage: str) -> None:
    other = Learned.FromString(kept.SerializeToString())
    if damage == "nan":
        other.arrays[3].data = np.full(len(other.arrays[3].data) // 8, np.nan).tobytes()
    if damage == "version":
        other.version = "0.0.1"
    if damage == "no kind of number":
        other.arrays[3].dtype = "<f9"
    if damage in ("too long", "no length"):
        other.string_length_m = {"too long": 1e9, "no length": -1200.0}[damage]
    data = other.SerializeToString()
    data = {"cut": data[:500], "garbage": b"\xff" * 99, "huge": bytes(10_000_001)}.get(damage, data)
    path = tmp_path / "test.learned"
    path.write_bytes(data)
    engine = Engine(SHORT)
    begun = take_up(path, SHORT, engine)
    assert begun.refused
    assert "refused and put aside" in begun.words
    assert not path.exists()
    assert (tmp_path / "test.refused").read_bytes() == data
    assert engine.estimator.law == Engine(SHORT).estimator.law


def test_a_file_is_there_as_a_whole_or_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "new" / "x.learned"
    write_whole(path, b"first")

    def full(_handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_whole(path, b"second")
    assert path.read_bytes() == b"first"


def test_a_disk_that_refuses_is_told_and_holds_nobody(engine: Engine, tmp_path: Path) -> None:
    (tmp_path / "state").write_text("a file where the folder should be")
    keeper = Keeper(tmp_path / "state" / "x.learned", SHORT, engine)
    assert "refused: [Errno 20] Not a directory" in keeper.begun.words  # and nothing could be put aside
    keeper.save()
    keeper.close()
    assert "x.learned: cannot be written" in keeper.trouble
    assert not keeper.saved_ns


@pytest.mark.process
def test_a_daemon_that_was_killed_goes_on_with_its_length_and_its_session_is_exact(
    bus: Bus, tmp_path: Path
) -> None:
    readings = simulated(8)
    with daemon(SHORT, bus, tmp_path) as sensor:
        with post(sensor) as rig:
            rig.send(samples(readings, time.time_ns()))
            rig.await_status(lambda status: status.ticks == len(readings), "all ticks")
            command(rig.session, rig.prefix, "longer 30 m")
            rig.await_status(lambda status: status.learned_saved_ns > 0, "what was learned saved")
        sensor.end(signal.SIGKILL)
        wait_until(lambda: len(sensor.sessions) == 1, "a complete session")
    assert path_of(sensor.rig).is_file()

    with daemon(SHORT, bus, tmp_path) as second:
        assert "goes on with what was learned until" in second.said
        assert "1230.0 m" in second.said
        with post(second) as rig:
            rig.send(samples(readings, time.time_ns()))
            status = rig.await_status(lambda status: status.ticks == len(readings), "all ticks")
            assert status.string_length_m == 1230
        assert second.end(signal.SIGTERM) == 0
    path = second.sessions[-1]
    told = [r.message.name for r in Session(path).messages((SENSOR_EVENT,)) if isinstance(r.message, Event)]
    assert "learned" in told
    for arguments in (["verify", str(path)], ["estimate", str(path), "-o", str(tmp_path / "again.mcap")]):
        assert CliRunner().invoke(main.app, arguments).exit_code == 0
    again, first = (
        [r.message.SerializeToString() for r in Session(each).messages(("bit/estimate",))]
        for each in (tmp_path / "again.mcap", path)
    )
    assert again == first
