"""Torn sessions mended at the next start, whatever became of the mending before."""

import errno
import fcntl
import os
from pathlib import Path

import pytest

from tests.clerks import NAME, RIG, Desk, numbers
from vsensor.recording.limits import Limits
from vsensor.recording.mend import mend, torn
from vsensor.recording.names import recovering
from vsensor.recording.recover import recover


@pytest.fixture
def part(tmp_path: Path) -> Path:
    """What a power cut leaves of a session."""
    desk = Desk(tmp_path, Limits())
    desk.remember()
    desk.send(10)
    desk.look()
    left = (tmp_path / f"{NAME}.part").read_bytes()
    desk.close()
    (tmp_path / NAME).unlink()
    path = tmp_path / f"{NAME}.part"
    path.write_bytes(left)
    return path


def whole(part: Path, name: str = NAME) -> bool:
    return numbers(part.with_name(name)) == [*range(10)] and part.with_suffix(".torn").exists()


def test_one_whose_mending_was_cut_off_is_mended(part: Path) -> None:
    recovering(part.with_suffix("")).write_bytes(b"half a session")
    assert torn(part.parent, RIG) == [part]
    assert "is mended" in mend(part)
    assert whole(part)
    assert not recovering(part.with_suffix("")).exists()


def test_one_that_was_mended_but_not_yet_renamed_is_not_mended_twice(part: Path) -> None:
    recover(part)
    assert "is mended" in mend(part)
    assert whole(part)
    assert len(list(part.parent.iterdir())) == 2


def test_a_session_that_has_its_name_is_not_written_over(part: Path) -> None:
    part.with_suffix("").write_bytes(b"precious")
    assert "is mended" in mend(part)
    assert part.with_suffix("").read_bytes() == b"precious"
    assert whole(part, NAME.replace(".mcap", "-2.mcap"))


def test_a_disk_without_room_leaves_it_for_the_next_start(
    part: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as full:
        full.setattr(os, "fsync", refuse)
        assert "tried again at the next start" in mend(part)
    assert list(part.parent.iterdir()) == [part]
    assert "is mended" in mend(part)
    assert whole(part)


def test_what_is_no_session_is_kept_and_said(part: Path) -> None:
    part.write_bytes(b"nothing")
    assert "nothing of it could be saved" in mend(part)
    assert part.with_suffix(".torn").read_bytes() == b"nothing"


def test_one_without_a_message_is_kept_and_said(part: Path) -> None:
    part.write_bytes(part.read_bytes()[:200])
    assert "nothing of it could be saved" in mend(part)
    assert list(part.parent.iterdir()) == [part.with_suffix(".torn")]


def test_what_another_is_mending_is_left_to_it(part: Path) -> None:
    with recovering(part.with_suffix("")).open("wb") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        assert torn(part.parent, RIG) == []
    assert torn(part.parent, RIG) == [part]
