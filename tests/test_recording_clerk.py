"""What is written where: files begun, split, ended, kept within limits; each message in one, or counted."""

import errno
import json
import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.clerks import NAME, Desk, at, made, numbers, sessions, states
from vsensor.recording import wire
from vsensor.recording.limits import Limits
from vsensor.recording.reader import Session


def test_parts_follow_one_another_without_a_message_between_and_each_begins_with_a_state(
    tmp_path: Path,
) -> None:
    desk = Desk(tmp_path, Limits(split_every=1e-9))
    for _ in range(3):
        desk.remember()
        desk.send(10)
        assert desk.look()["wants"]
    desk.close()

    parts = sessions(tmp_path)
    assert [numbers(part) for part in parts] == [[*range(10)], [*range(10, 20)], [*range(20, 30)]]
    assert [states(part) for part in parts] == [[(0, 0)], [(0, 10)], [(0, 20)]]
    assert [Session(part).metadata.get("continues") for part in parts] == [None, *(p.name for p in parts[:2])]
    assert [Session(part).recorder["ended"] for part in parts] == [
        "continued in the next part",
        "continued in the next part",
        "closed by the daemon",
    ]
    assert all(Session(part).configuration == "[rig]" and Session(part).complete for part in parts)
    assert sorted(path for news in desk.news for path in news["complete"]) == sorted(map(str, parts))


def test_a_part_that_is_large_enough_is_split(tmp_path: Path) -> None:
    desk = Desk(tmp_path, Limits(split_size=40_000))
    desk.remember()
    wanted = []
    for _ in range(6):
        desk.send(1000)
        wanted.append(desk.look()["wants"])
        desk.remember()
    desk.close()
    assert wanted.count(True) == len(sessions(tmp_path)) - 1 > 0
    assert sum(len(numbers(part)) for part in sessions(tmp_path)) == 6000


def test_on_command_it_stops_starts_and_splits(tmp_path: Path) -> None:
    desk = Desk(tmp_path, Limits(), begin=False)
    desk.remember()
    desk.send(5)  # into no file: nobody has asked for one
    desk.remember(wire.START, tmp_path / "a.mcap")
    desk.send(5)
    desk.remember(wire.SPLIT, tmp_path / "b.mcap")
    desk.send(5)
    desk.order(order=wire.STOP)
    desk.send(5)
    assert desk.look()["path"] == ""
    desk.remember(wire.START, tmp_path / "c.mcap")
    desk.send(5)
    desk.close()

    found = [numbers(tmp_path / f"{name}.mcap") for name in "abc"]
    assert found == [[*range(5, 10)], [*range(10, 15)], [*range(20, 25)]]
    assert desk.news[-1]["lost"] == 0
    assert Session(tmp_path / "b.mcap").recorder["ended"] == "stopped on command"
    assert desk.events.count(("recording", True)) == 3
    assert desk.events.count(("recording", False)) == 3


def test_behind_a_loss_a_state_is_written_and_only_there(tmp_path: Path) -> None:
    desk = Desk(tmp_path, Limits())
    desk.remember()
    desk.send(5)
    desk.remember()
    desk.send(5)
    desk.sent += 3  # the daemon could not send these
    desk.remember(dropped=3)
    desk.send(5)
    desk.remember(dropped=3)
    desk.send(5)
    desk.close()
    (part,) = sessions(tmp_path)
    assert states(part) == [(0, 0), (10, 13)]


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Sets the clock forward."""
    ahead = [0.0]
    real = time.monotonic
    monkeypatch.setattr(time, "monotonic", lambda: real() + ahead[0])

    def forward(seconds: float) -> None:
        ahead[0] += seconds

    return forward


def test_a_snapshot_holds_the_last_minutes_from_a_state_on(
    tmp_path: Path, clock: Callable[[float], None]
) -> None:
    desk = Desk(tmp_path, Limits(memory=300), begin=False)
    desk.send(3)  # before anything can be run again
    for _ in range(10):
        desk.remember()
        desk.send(10)
        clock(60)
    desk.order(order=wire.SNAPSHOT, path=str(tmp_path / "s.mcap"), seconds=150.0)
    desk.send(5)
    desk.look()
    desk.order(order=wire.SNAPSHOT, path=str(tmp_path / "all.mcap"), seconds=float("inf"))
    desk.close()

    assert numbers(tmp_path / "s.mcap") == [*range(73, 103)]
    assert states(tmp_path / "s.mcap") == [(0, 73)]
    assert numbers(tmp_path / "all.mcap") == [*range(43, 108)]
    assert Session(tmp_path / "s.mcap").complete
    assert desk.events == [("snapshot", True)] * 2
    assert 299 < desk.news[0]["figures"]["recording_memory_s"] < 361


def test_a_snapshot_that_cannot_be_kept_is_told(tmp_path: Path) -> None:
    desk = Desk(tmp_path, Limits(memory=300), begin=False)
    desk.order(order=wire.SNAPSHOT, path=str(tmp_path / "s.mcap"), seconds=10.0)
    desk.remember()
    desk.order(order=wire.SNAPSHOT, path="/proc/no/t.mcap", seconds=10.0)
    told = desk.look()["events"]
    assert [(name, begins) for name, begins, _ in told] == [("snapshot", False)] * 2
    assert "nothing is held in memory yet" in told[0][2]
    assert "cannot be created" in told[1][2]


def test_no_session_is_written_over(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"precious")
    (tmp_path / "a-2.mcap.part").write_bytes(b"precious")
    desk = Desk(tmp_path, Limits(), begin=False)
    desk.remember(wire.START, tmp_path / "a.mcap")
    desk.send(1)
    desk.close()
    assert (tmp_path / "a.mcap").read_bytes() == b"precious"
    assert numbers(tmp_path / "a-3.mcap") == [0]


def test_whatever_there_is_to_tell_fits_into_packets_and_nothing_is_left_out(tmp_path: Path) -> None:
    folder = tmp_path / ("long" * 50)
    folder.mkdir()
    for number in range(60):
        made(folder / at(10, more=f"-{number + 2}"), age_s=100)
    desk = Desk(folder, Limits(keep_for=50))
    told = [desk.look()]
    while desk.clerk.has_more:
        told.append(desk.look())
    desk.close()
    assert sum(name == "session_deleted" for news in told for name, _, _ in news["events"]) == 60
    assert len(told) > 1
    assert all(len(json.dumps(news)) < wire.PACKET_BYTES for news in told)


def test_a_disk_that_refuses_is_tried_again_and_what_it_tore_is_mended(
    tmp_path: Path, clock: Callable[[float], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    desk = Desk(tmp_path, Limits())
    desk.remember()
    desk.send(10)
    desk.look()

    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as full:
        full.setattr(os, "fsync", refuse)
        desk.send(5)
        assert "No space left on device" in desk.look()["trouble"]
        assert desk.failed()
        clock(5)
        assert not desk.look()["wants"]
        clock(6)
        assert desk.look()["wants"]
        desk.remember()  # and it refuses again
        assert desk.look()["trouble"]
    desk.send(3)
    clock(11)
    assert desk.look()["wants"]
    desk.remember()
    desk.send(10)
    deadline = time.monotonic() + 30
    while ("session_mended", True) not in desk.events:
        assert time.monotonic() < deadline
        desk.look()
        time.sleep(0.05)
    desk.close()

    torn, whole = sorted(path for path in sessions(tmp_path) if numbers(path))
    assert numbers(torn)[:10] == [*range(10)]
    assert numbers(whole) == [*range(18, 28)]
    assert not desk.failed()
    assert desk.news[-1]["lost"] >= 8


def test_a_recording_that_begins_in_the_same_second_takes_another_name(tmp_path: Path) -> None:
    (tmp_path / NAME).write_bytes(b"precious")
    desk = Desk(tmp_path, Limits())
    desk.remember()
    desk.send(1)
    desk.close()
    assert (tmp_path / NAME).read_bytes() == b"precious"
    assert numbers(tmp_path / NAME.replace(".mcap", "-2.mcap")) == [0]
