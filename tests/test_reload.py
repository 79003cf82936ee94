"""SIGHUP: what may change is taken up, all else is refused with why, and the sensor lives on."""

import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any, cast

import pytest

from tests.daemons import Daemon, Post, daemon, open_files, post, wait_until
from tests.rigs import SHORT
from vsensor.bus import command
from vsensor.config import Bus, Rig, effective_toml
from vsensor.messages import SENSOR_EVENT, Event
from vsensor.recording.reader import Session
from vsensor.service.awake import DEVICE
from vsensor.service.reload import Outcome, Reload, changes, is_safe


def changed(**update: object) -> Rig:
    return SHORT.model_copy(update=update)


LONGER = changed(string=(SHORT.string[0].model_copy(update={"length": 1230.0}),))
ASKED = {"realtime": "prefer", "priority": 30, "stay_awake": True}
REALTIME = changed(loop=SHORT.loop.model_copy(update=ASKED))


def test_each_key_that_differs_is_named_with_what_it_was_and_is() -> None:
    assert changes(SHORT, SHORT) == {}
    assert changes(SHORT, LONGER) == {"string[1].length": "1200.0 → 1230.0"}
    assert changes(SHORT, REALTIME) == {
        "loop.realtime": "off → prefer",
        "loop.priority": "40 → 30",
        "loop.stay_awake": "False → True",
    }
    two = changed(string=(*SHORT.string, SHORT.string[0]))
    assert all(key.startswith("string[2].") for key in changes(SHORT, two))


def test_only_what_no_estimate_hangs_on_is_safe() -> None:
    assert all(is_safe(f"loop.{key}") for key in ASKED)
    assert is_safe("view.history")
    for key in ("loop.rate", "string[1].length", "bus.prefix", "recording.folder", "viewer", "rig.name"):
        assert not is_safe(key)


def read(path: Path, now: Rig) -> Outcome:
    reload = Reload(path)
    assert reload.result(now) is None
    reload.begin()
    found: list[Outcome] = []

    def came() -> bool:
        found.extend(result for result in [reload.result(now)] if result is not None)
        return bool(found)

    wait_until(came, "a result")
    assert reload.result(now) is None
    return found[0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (effective_toml(SHORT), "nothing has changed"),
        (effective_toml(LONGER), "refused: string[1].length 1200.0 → 1230.0: needs a new start"),
        ("[rig]\nname = 5", "refused: "),
    ],
    ids=["the same", "another string", "faulty"],
)
def test_what_is_not_taken_up_leaves_all_as_it_was(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(text, encoding="utf-8")
    done = read(path, SHORT)
    assert done.rig is SHORT
    assert done.words.startswith(said)
    assert done.refused == said.startswith("refused")


def test_of_a_file_with_one_unsafe_change_nothing_is_taken_up(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(effective_toml(REALTIME.model_copy(update={"string": LONGER.string})), encoding="utf-8")
    done = read(path, SHORT)
    assert done.rig is SHORT
    assert "loop" not in done.words


def interrupted(reload: Reload, line: int) -> Outcome | None:
    """Its result, while a SIGHUP comes before that line of the method, counted as they are run."""
    run = 0

    def trace(frame: FrameType, event: str, _told: object) -> Any:
        nonlocal run
        if frame.f_code is not Reload.result.__code__:
            return None
        if event == "line":
            run += 1
            if run == line:
                reload.begin()
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        return reload.result(SHORT)
    finally:
        sys.settrace(before)


@pytest.mark.parametrize("line", range(1, 12))
def test_a_signal_that_comes_while_the_result_is_asked_for_refuses_nothing(tmp_path: Path, line: int) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(effective_toml(SHORT), encoding="utf-8")
    reload = Reload(path)
    reload.begin()
    wait_until(lambda: not any(thread.name == "reload" for thread in threading.enumerate()), "it is read")
    found: list[Outcome] = []

    def came() -> bool:
        found.extend(result for result in [reload.result(SHORT)] if result is not None)
        return bool(found)

    found.extend(result for result in [interrupted(reload, line)] if result is not None)
    wait_until(lambda: bool(found) or came(), "a result")
    assert [done.words for done in found] == ["nothing has changed"]
    wait_until(lambda: not any(thread.name == "reload" for thread in threading.enumerate()), "all is read")


@pytest.mark.process
def test_parts_that_begin_after_a_change_tell_it(bus: Bus, tmp_path: Path) -> None:
    recording = SHORT.recording.model_copy(update={"enabled": True, "keep_free": 0.0})
    with (
        daemon(SHORT.model_copy(update={"recording": recording}), bus, tmp_path) as sensor,
        post(sensor) as rig,
    ):
        rig.await_status(lambda status: status.realtime == "off", "a status")
        command(rig.session, rig.prefix, "split recording")
        _hang_up(sensor, lambda now: now.model_copy(update={"loop": REALTIME.loop}))
        assert "taken up" in _told(rig, 1)
        command(rig.session, rig.prefix, "split recording")
        assert sensor.end(signal.SIGTERM) == 0
    # By their numbers: of two that begin in one second the names sort the other way round.
    parts = sorted(map(Session, sensor.sessions), key=lambda part: int(part.metadata["part"]))
    assert [part.metadata["realtime"] for part in parts] == ["off", "off", "prefer"]
    assert ['realtime = "prefer"' in (part.configuration or "") for part in parts] == [False, False, True]


@pytest.mark.process
def test_a_daemon_takes_up_safe_keys_and_refuses_the_rest(bus: Bus, tmp_path: Path) -> None:
    with daemon(SHORT, bus, tmp_path) as sensor, post(sensor) as rig:
        rig.await_status(lambda status: status.realtime == "off", "a status")
        _hang_up(sensor, lambda now: now.model_copy(update={"string": LONGER.string}))
        assert "refused: string[1].length" in _told(rig, 1)
        sensor.config.write_text("nonsense", encoding="utf-8")
        sensor.process.send_signal(signal.SIGHUP)
        assert "not valid TOML" in _told(rig, 2)
        _hang_up(sensor, lambda now: now.model_copy(update={"loop": REALTIME.loop}))
        assert "taken up: loop.realtime off → prefer" in _told(rig, 3)
        status = rig.await_status(lambda status: status.realtime == "prefer", "another priority")
        assert status.scheduling in ("SCHED_FIFO 30", "SCHED_OTHER")
        assert status.kept_awake == (str(DEVICE) in open_files(sensor.process.pid))
        _hang_up(sensor, lambda now: now)
        assert "loop.realtime prefer → off" in _told(rig, 4)
        status = rig.await_status(lambda status: status.realtime == "off", "the old priority")
        assert status.scheduling == "SCHED_OTHER"
        assert not status.memory_locked
        assert not status.kept_awake
        assert str(DEVICE) not in open_files(sensor.process.pid)
        assert sensor.end(signal.SIGTERM) == 0


def _hang_up(sensor: Daemon, change: Callable[[Rig], Rig]) -> None:
    sensor.config.write_text(effective_toml(change(sensor.rig)), encoding="utf-8")
    sensor.process.send_signal(signal.SIGHUP)


def _told(rig: Post, count: int) -> str:
    def told() -> list[str]:
        events = cast("list[Event]", rig.heard(SENSOR_EVENT))
        return [event.text for event in events if event.name == "configuration"]

    wait_until(lambda: len(told()) >= count, f"{count} readings of the configuration")
    return told()[count - 1]
