"""Sessions that are removed or moved while they are written: it is told and counted, and another begins."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.clerks import Desk, numbers, sessions
from tests.daemons import daemon, post, wait_until
from tests.live import at_work
from tests.rigs import SHORT
from vsensor.bus import command
from vsensor.config import Bus
from vsensor.recording import wire
from vsensor.recording.limits import Limits
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine


def move(folder: Path) -> None:
    folder.rename(folder.with_name("elsewhere"))


def put_another_there(folder: Path) -> None:
    (part,) = folder.glob("*.part")
    part.unlink()
    part.write_bytes(b"precious")


WAYS = [shutil.rmtree, move, put_another_there]


@pytest.mark.parametrize("take", WAYS)
def test_it_is_seen_within_a_second_and_all_that_was_in_it_is_counted(
    tmp_path: Path, take: Callable[[Path], None]
) -> None:
    desk = Desk(tmp_path / "recordings", Limits())
    desk.remember()
    desk.send(10)
    desk.look()
    take(desk.folder)
    desk.send(5)
    news = desk.look()
    assert "removed or moved" in news["trouble"]
    assert (news["path"], news["wants"], news["lost"]) == ("", True, 16)  # the state is one of them
    others = len(list(desk.folder.glob("*.part")))
    desk.remember()
    desk.send(3)
    assert desk.look()["trouble"] == ""
    wait_until(lambda: bool(desk.look()) and desk.events.count(("session_mended", True)) == others, "mending")
    desk.close()
    assert [numbers(path) for path in sessions(desk.folder)] == [[15, 16, 17]]
    assert [torn.read_bytes() for torn in desk.folder.glob("*.torn")] == [b"precious"] * others
    assert not desk.failed()


@pytest.mark.parametrize("take", WAYS)
def test_where_it_ends_before_the_second_is_over_it_is_counted_too(
    tmp_path: Path, take: Callable[[Path], None]
) -> None:
    desk = Desk(tmp_path / "recordings", Limits())
    desk.remember()
    desk.send(10)
    take(desk.folder)
    desk.close()
    assert desk.failed()
    assert desk.news[-1]["lost"] == 11
    assert [part.read_bytes() for part in desk.folder.glob("*")] in ([], [b"precious"])


def test_a_file_in_the_place_of_the_folder_is_named_until_it_is_out_of_the_way(tmp_path: Path) -> None:
    desk = Desk(tmp_path / "recordings", Limits())
    desk.remember()
    shutil.rmtree(desk.folder)
    desk.folder.touch()
    desk.look()
    desk.remember()
    assert "a file is in the way" in desk.look()["trouble"]
    desk.order(order=wire.STOP)
    desk.folder.unlink()
    assert desk.look()["trouble"] == "", "nothing keeps from recording who does not want to"
    desk.close()


def test_of_a_session_that_cannot_be_completed_on_command_no_trouble_stays(tmp_path: Path) -> None:
    """Else it would refuse each `start recording` from then on."""
    desk = Desk(tmp_path / "recordings", Limits())
    desk.remember()
    shutil.rmtree(desk.folder)
    desk.order(order=wire.STOP)
    news = desk.look()
    assert (news["trouble"], news["wanted"]) == ("", False)
    assert "removed or moved" in news["events"][-1][2]
    desk.remember(wire.START, desk.folder / "a.mcap")
    desk.send(2)
    desk.close()
    assert numbers(desk.folder / "a.mcap") == [0, 1]


@pytest.mark.process
def test_a_daemon_whose_folder_is_moved_says_so_and_goes_on_in_a_new_one(bus: Bus, tmp_path: Path) -> None:
    with at_work(bus, tmp_path) as (sensor, near, rig):
        near.await_status(lambda status: status.ticks == rig.readings, "ticks")
        move(sensor.rig.recording.folder)
        rig.live(2)
        status = near.await_status(lambda status: status.recorder_dropped > 100, "what is lost")
        status = near.await_status(lambda status: status.HasField("recording"), "another recording")
        wait_until(lambda: Path(f"{status.recording}.part").exists(), "its file")
        assert "removed or moved" in sensor.said
        rig.live(2)
        near.await_status(lambda status: status.ticks == rig.readings, "all ticks")
        assert sensor.end() == 0
        (anew,) = sensor.sessions
    assert verify(Session(anew), Engine(SHORT)).exact


@pytest.mark.process
def test_who_orders_a_recording_is_not_told_that_there_is_one_before_it_has_begun(
    bus: Bus, tmp_path: Path
) -> None:
    settings = SHORT.recording.model_copy(update={"enabled": False})
    rig = SHORT.model_copy(update={"recording": settings})
    with daemon(rig, bus, tmp_path) as sensor, post(sensor) as near:
        sensor.rig.recording.folder.write_text("in the way")
        said = command(near.session, near.prefix, "start recording")
        assert "is to record into" in said
        assert "vsensor status" in said
        status = near.await_status(lambda status: status.HasField("recording_trouble"), "trouble told")
        assert "a file is in the way" in status.recording_trouble
        assert sensor.end() == 0
