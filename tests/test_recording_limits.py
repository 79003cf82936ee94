"""A disk that is full and has room again; sessions that go, and torn ones that are mended."""

import os
import time
from collections.abc import Sequence
from pathlib import Path

from tests.clerks import NAME, RIG, Desk, at, made, numbers, sessions, states
from vsensor.recording.limits import Limits
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter


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


def test_what_a_session_was_mended_from_counts_and_goes_as_the_sessions_do(tmp_path: Path) -> None:
    paths = [made(tmp_path / at(n), age_s=100 - n, size=100_000) for n in range(1, 5)]
    paths[0], paths[2] = (paths[n].rename(f"{paths[n]}.torn") for n in (0, 2))
    of_another = made(tmp_path / at(1, rig=f"{RIG}-2"), age_s=100, size=100_000)
    of_another = of_another.rename(f"{of_another}.torn")
    Desk(tmp_path, Limits(keep_size=250_000)).close()
    assert [path.exists() for path in paths] == [False, False, True, True]
    assert of_another.exists()


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
