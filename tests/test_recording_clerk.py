"""What is written where: files begun, split, ended, kept within limits; each message in one, or counted."""

import errno
import json
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from vsensor.messages import SENSOR_STATE, SURFACE_TORQUE, Sample, State
from vsensor.recording import wire
from vsensor.recording.clerk import Clerk, News
from vsensor.recording.disk import Disk
from vsensor.recording.limits import Limits
from vsensor.recording.part import Head
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

RIG = "r"
HEAD = Head("[rig]", {"rig": RIG}, "zstd")
NAME = f"{RIG}-20260101T000000Z.mcap"


class Desk:
    """A clerk, and what a daemon would hand to it."""

    def __init__(self, folder: Path, limits: Limits, begin: bool = True) -> None:
        self.folder = folder
        self.free = 1 << 40
        self.sent = 0
        self.news: list[News] = []
        disk = Disk(folder, RIG, limits, lambda _: self.free)
        self.clerk = Clerk(folder / NAME, HEAD, limits, disk=disk)
        if begin:
            self.clerk.begin(folder / NAME)

    def send(self, count: int) -> None:
        for _ in range(count):
            data = Sample(sequence=self.sent, value=self.sent).SerializeToString()
            topic = SURFACE_TORQUE.encode()
            head = wire.HEAD.pack(len(topic), len(data), self.sent, self.sent)
            self.clerk.take(head + topic + data)
            self.sent += 1

    def remember(self, order: str = wire.KEEP, path: Path | None = None, dropped: int = 0) -> None:
        """Hand over a state; its number is that of the next message."""
        header = State(number=self.sent).SerializeToString()
        words = {"order": order, "path": "" if path is None else str(path), "dropped": dropped, "state": 0}
        remembered = len(header).to_bytes(4, "little") + header
        self.clerk.take(wire.Checkpoint(words, time.time_ns(), remembered))

    def order(self, **words: Any) -> None:
        self.clerk.take(wire.packed_order({"dropped": 0, "path": "", "seconds": 0.0, **words}, 0))

    def look(self) -> News:
        self.clerk.each_second()
        self.clerk.work()
        self.news.append(self.clerk.news())
        return self.news[-1]

    def close(self) -> None:
        self.order(order=wire.FAREWELL)
        self.clerk.close(told_to_end=False)
        self.news.append(self.clerk.news())

    def failed(self) -> bool:
        return self.clerk.failed

    @property
    def events(self) -> list[tuple[str, bool]]:
        return [(name, begins) for news in self.news for name, begins, _ in news["events"]]


def numbers(path: Path) -> list[int]:
    """Of the samples in a session."""
    return [r.message.sequence for r in Session(path).messages((SURFACE_TORQUE,))]  # type: ignore[union-attr]


def states(path: Path) -> list[tuple[int, int]]:
    """Each state in a session: behind how many samples it stands, and the number that it tells."""
    found, samples = [], 0
    for topic, message, _, _ in Session(path).messages():
        if topic == SENSOR_STATE and isinstance(message, State):
            found.append((samples, message.number))
        samples += topic == SURFACE_TORQUE
    return found


def sessions(folder: Path) -> list[Path]:
    """Complete ones, in the order of their making."""
    return sorted(folder.glob("*.mcap"), key=lambda path: path.stat().st_mtime_ns)


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


def test_a_full_disk_ends_the_file_in_time_and_room_begins_another(tmp_path: Path) -> None:
    desk = Desk(tmp_path, Limits(keep_free=1e9))
    desk.remember()
    desk.send(10)
    assert desk.look()["trouble"] == ""
    desk.free = 999_000_000
    full = desk.look()
    assert full["path"] == ""
    assert "the disk has only 999 MB left, 1 GB must stay" in full["trouble"]
    assert not full["wants"]
    (whole,) = sessions(tmp_path)
    assert numbers(whole) == [*range(10)]
    assert Session(whole).complete

    desk.send(7)
    desk.free = 1_050_000_000  # not so much that it could write for long
    assert not desk.look()["wants"]
    desk.free = 2_000_000_000
    assert desk.look()["wants"]
    desk.remember()
    desk.send(10)
    desk.close()

    assert desk.news[-1]["lost"] == 7
    assert desk.news[-1]["trouble"] == ""
    assert desk.events == [("recording", begins) for begins in (True, False, True, False)]
    assert not desk.failed()
    second = sessions(tmp_path)[1]
    assert numbers(second) == [*range(17, 27)]
    assert states(second) == [(0, 17)]


def test_without_room_at_the_start_nothing_is_written_until_there_is(tmp_path: Path) -> None:
    desk = Desk(tmp_path, Limits(keep_free=1e9), begin=False)
    desk.free = 10
    desk.clerk.begin(tmp_path / NAME)
    desk.remember()
    assert "must stay" in desk.look()["trouble"]
    assert list(tmp_path.iterdir()) == []
    desk.free = 1 << 40
    assert desk.look()["wants"]
    desk.remember()
    desk.send(3)
    desk.close()
    assert [numbers(part) for part in sessions(tmp_path)] == [[0, 1, 2]]


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


def made(path: Path, rig: str = RIG, age_s: float = 0.0, complete: bool = True, size: int = 0) -> Path:
    """A session of some age, filled up to some size."""
    with SessionWriter(path, configuration=" " * size, metadata={"rig": rig}, compression="none") as writer:
        writer.write(SURFACE_TORQUE, b"", 1, 1)
    if not complete:
        path.write_bytes(path.read_bytes()[:-20])
    os.utime(path, (time.time() - age_s,) * 2)
    return path


def at(hour: int, rig: str = RIG, more: str = "") -> str:
    return f"{rig}-20260101T{hour:02d}0000Z{more}.mcap"


def test_only_complete_sessions_of_this_rig_are_deleted_for_their_age(tmp_path: Path) -> None:
    old = made(tmp_path / at(1), age_s=100)
    kept: Sequence[Path] = [
        made(tmp_path / at(2), age_s=10),
        made(tmp_path / at(3, more="-snapshot"), age_s=100),
        made(tmp_path / at(4), rig="another", age_s=100),
        made(tmp_path / at(5, rig=f"{RIG}-2"), rig=f"{RIG}-2", age_s=100),
        made(tmp_path / at(6), age_s=100, complete=False),
        made(tmp_path / "renamed.mcap", age_s=100),
        made(tmp_path / at(7, more=".mcap.part").replace(".mcap.part", "-x"), age_s=100),
    ]
    (tmp_path / at(8)).write_bytes(b"no session")
    os.utime(tmp_path / at(8), (0, 0))
    desk = Desk(tmp_path, Limits(keep_for=50))
    news = desk.look()
    assert not old.exists()
    assert all(path.exists() for path in kept)
    assert (tmp_path / at(8)).exists()
    desk.close()
    assert news["figures"]["recording_deleted"] == 1
    assert ("session_deleted", True) in desk.events


def test_the_oldest_go_while_all_are_too_large(tmp_path: Path) -> None:
    made_ = [made(tmp_path / at(n), age_s=100 - n, size=100_000) for n in range(1, 6)]
    Desk(tmp_path, Limits(keep_size=250_000)).close()
    assert [path.exists() for path in made_] == [False, False, False, True, True]


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


def test_a_torn_session_is_mended_at_the_next_start_and_the_torn_one_kept(tmp_path: Path) -> None:
    whole = made(tmp_path / at(1), size=1000)
    data = whole.read_bytes()
    whole.unlink()
    torn = tmp_path / f"{at(1)}.part"
    torn.write_bytes(data[:-20])
    (tmp_path / f"{at(2)}.part").touch()
    with SessionWriter(
        tmp_path / at(3), configuration="", metadata={"rig": RIG}, compression="none"
    ) as being_written:
        desk = Desk(tmp_path, Limits())
        deadline = time.monotonic() + 30
        while ("session_mended", True) not in desk.events:
            assert time.monotonic() < deadline
            desk.look()
            time.sleep(0.05)
        assert being_written.part.exists()

    assert numbers(whole) == [0]
    assert Session(whole).complete
    assert (tmp_path / f"{at(1)}.torn").read_bytes() == data[:-20]
    assert (tmp_path / f"{at(2)}.torn").exists()
    assert not torn.exists()
    desk.close()
