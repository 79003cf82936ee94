"""A player that is paused, stepped, sought through and ended from the keyboard."""

import math
from pathlib import Path

import pytest

from tests.players import MS, SECOND, FakeClock, Listener, after, played, session_of
from vsensor.recording.course import Course
from vsensor.recording.player import Command, Progress, play


def test_a_pause_holds_and_the_rest_keeps_its_spacing(tmp_path: Path) -> None:
    session = session_of(tmp_path / "a.mcap", [0, 1000, 2000, 3000])
    script = {1200 * MS: Command.PAUSE, 5200 * MS: Command.PAUSE}
    listener = played(session, script, FakeClock())
    assert listener.after_ns == [0, SECOND, 6 * SECOND, 7 * SECOND]


def test_paused_each_step_gives_one_sample(tmp_path: Path) -> None:
    session = session_of(tmp_path / "a.mcap", [0, 1000, 2000, 3000, 4000])
    script = {
        100 * MS: Command.PAUSE,
        500 * MS: Command.STEP,
        600 * MS: Command.STEP,
        10 * SECOND: Command.PAUSE,
    }
    listener = played(session, script, FakeClock())
    assert listener.after_ns == [0, 500 * MS, 600 * MS, 11 * SECOND, 12 * SECOND]


def test_a_step_while_playing_does_nothing(tmp_path: Path) -> None:
    session = session_of(tmp_path / "a.mcap", [0, 1000])
    listener = played(session, {100 * MS: Command.STEP}, FakeClock())
    assert listener.after_ns == [0, SECOND]


def test_seeking_goes_on_from_there_at_once_and_ends_stay_ends(tmp_path: Path) -> None:
    session = session_of(tmp_path / "a.mcap", [1000 * n for n in range(100)])
    script = {
        5500 * MS: Command.FORWARD,
        6100 * MS: Command.FAR_FORWARD,
        7100 * MS: Command.FAR_BACK,
        8100 * MS: Command.FAR_BACK,
        9100 * MS: Command.QUIT,
    }
    listener = played(session, script, FakeClock())
    seconds = [round(stamp / 1000) - 5 for stamp in listener.stamps_ms()]
    assert seconds == [0, 1, 2, 3, 4, 5, 16, 77, 18, 0]
    assert listener.after_ns[5:8] == [5 * SECOND, 6 * SECOND, 7 * SECOND]


def test_sought_while_paused_it_stays_paused(tmp_path: Path) -> None:
    session = session_of(tmp_path / "a.mcap", [1000 * n for n in range(100)])
    script = {
        1500 * MS: Command.PAUSE,
        2000 * MS: Command.FORWARD,
        9000 * MS: Command.STEP,
        9500 * MS: Command.QUIT,
    }
    seen: list[Progress] = []
    listener = played(session, script, FakeClock(), show=seen.append)
    assert len(listener.samples) == 3
    assert listener.stamps_ms()[-1] == 17_000
    assert listener.after_ns[-1] == 9 * SECOND
    assert seen[-1] == Progress(pytest.approx(12.0), 3, True)  # type: ignore[arg-type]


def test_beyond_the_end_there_is_nothing_more(tmp_path: Path) -> None:
    session = session_of(tmp_path / "a.mcap", [1000 * n for n in range(30)])
    listener = played(session, {100: Command.FAR_FORWARD}, FakeClock())
    assert [round(stamp / 1000) - 5 for stamp in listener.stamps_ms()] == [0, 29]


def test_as_fast_as_it_goes_never_waits_but_obeys(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock, work_ns=1000)
    session = session_of(tmp_path / "a.mcap", [1000 * n for n in range(1000)])
    assert play(Course([session]), listener.put, clock=clock, speed=math.inf) == 1000
    assert clock.time_ns - listener.times_ns[0] == 1000 * 1000
    script = {10_000: Command.PAUSE, 5 * SECOND: Command.PAUSE, 5 * SECOND + 10_000: Command.QUIT}
    again = Listener(clock, work_ns=1000)
    count = play(Course([session]), again.put, clock=clock, speed=math.inf, command=after(clock, script))
    assert 10 < count < 100
    assert 5 * SECOND <= again.after_ns[-1] < 6 * SECOND


def test_present_stamps_stay_present_when_it_is_sought(tmp_path: Path) -> None:
    session = session_of(tmp_path / "a.mcap", [1000 * n for n in range(100)])
    script = {2500 * MS: Command.FORWARD, 4500 * MS: Command.QUIT}
    clock = FakeClock()
    listener = played(session, script, clock, stamp=lambda: clock.time_ns)
    assert [stamp - 777_000 for stamp in listener.stamps_ms()] == [0, 1000, 2000, 3000, 4000]
    assert [sample.sequence - 100 for sample in listener.samples] == [0, 1, 2, 13, 14]


def test_quitting_ends_a_long_wait_soon(tmp_path: Path) -> None:
    session = session_of(tmp_path / "a.mcap", [0, 3_600_000])
    clock = FakeClock()
    start_ns = clock.time_ns
    assert len(played(session, {SECOND: Command.QUIT}, clock).samples) == 1
    assert clock.time_ns - start_ns < 1.1 * SECOND
