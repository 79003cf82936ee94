"""A session played: each sample at its time, by any clock, once or over and over."""

import math
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.players import MS, SECOND, FakeClock, Listener, after, session_of
from vsensor.errors import InputError
from vsensor.messages import BIT_SPEED, SURFACE_SPEED, SURFACE_TORQUE, Message, Sample
from vsensor.recording.course import Course
from vsensor.recording.player import Command, play
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter


def test_samples_come_at_the_spacing_of_their_own_times(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    count = play(Course([session_of(tmp_path / "a.mcap", [0, 10, 20, 1020])]), listener.put, clock=clock)
    assert count == 4
    assert listener.after_ns == [0, 10 * MS, 20 * MS, 1020 * MS]
    assert listener.stamps_ms() == [5000, 5010, 5020, 6020]
    assert set(listener.topics) == {SURFACE_TORQUE}


@pytest.mark.parametrize("speed", [0.1, 1.0, 3.0, 20.0])
def test_oversleeping_and_work_never_add_up(tmp_path: Path, speed: float) -> None:
    clock = FakeClock(overshoot_ns=300_000)
    listener = Listener(clock, work_ns=100_000)
    session = session_of(tmp_path / "a.mcap", [10 * n for n in range(500)])
    play(Course([session]), listener.put, clock=clock, speed=speed)
    start_ns = listener.times_ns[0]
    for number, time_ns in enumerate(listener.times_ns[1:], 1):
        late_ns = time_ns - start_ns - 10 * MS * number / speed
        assert 0 <= late_ns <= 400_001


def test_what_is_late_goes_out_at_once(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)

    def put(topic: str, sample: Message) -> None:
        listener.put(topic, sample)
        if len(listener.samples) == 2:
            clock.time_ns += 35 * MS  # the bus held us up

    play(Course([session_of(tmp_path / "a.mcap", [0, 10, 20, 30, 40, 50, 60])]), put, clock=clock)
    assert listener.after_ns == [0, 10 * MS, 45 * MS, 45 * MS, 45 * MS, 50 * MS, 60 * MS]


def test_samples_out_of_order_stay_so(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 20, 10, 30], arrivals_ms=[0, 20, 21, 30])
    play(Course([session]), listener.put, clock=clock)
    assert listener.stamps_ms() == [5000, 5020, 5010, 5030]
    assert listener.after_ns == [0, 20 * MS, 20 * MS, 30 * MS]


def test_one_wild_stamp_does_not_hold_the_player_up(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 10, 1e12, 30, 40], arrivals_ms=[0, 10, 20, 30, 40])
    play(Course([session]), listener.put, clock=clock)
    assert listener.after_ns == [0, 10 * MS, 20 * MS, 30 * MS, 40 * MS]


def test_start_and_duration_pick_a_piece(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [10 * n for n in range(300)])
    count = play(Course([session]), listener.put, clock=clock, start_s=1.0, end_s=1.5)
    assert count == 50
    assert listener.stamps_ms()[0] == 6000
    assert listener.after_ns[-1] == 490 * MS


@pytest.mark.parametrize("start_s", [1.0, math.inf])
def test_nothing_to_play_is_an_error(tmp_path: Path, start_s: float) -> None:
    clock = FakeClock()
    session = session_of(tmp_path / "a.mcap", [0, 10])
    with pytest.raises(
        InputError, match=r"a\.mcap: holds none of surface/torque, .* between .* s and its end at 0\.01 s"
    ):
        play(Course([session]), Listener(clock).put, clock=clock, start_s=start_s)


def test_present_stamps_keep_their_spacing(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 10, 25])
    play(Course([session]), listener.put, clock=clock, speed=5.0, stamp=lambda: 10**18)
    assert [sample.time_ns - 10**18 for sample in listener.samples] == [0, 10 * MS, 25 * MS]


def test_a_loop_runs_on_in_time_and_sequence(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 10, 20])
    count = play(
        Course([session]), listener.put, clock=clock, loop=True, command=after(clock, {95 * MS: Command.QUIT})
    )
    assert count == 10
    assert listener.after_ns == [10 * MS * n for n in range(10)]
    assert listener.stamps_ms() == [5000 + 10 * n for n in range(10)]
    assert [sample.sequence for sample in listener.samples] == [100 + n for n in range(10)]


def test_a_looped_piece_never_turns_time_back(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 10, 20, 33, 41, 60])
    stop = after(clock, {SECOND: Command.QUIT})
    play(Course([session]), listener.put, clock=clock, loop=True, start_s=0.01, end_s=0.05, command=stop)
    assert len(listener.samples) > 50
    assert all(one < other for one, other in pairwise(listener.stamps_ms()))
    assert all(one < other for one, other in pairwise(listener.after_ns))


def test_sessions_follow_one_another_at_their_gap_or_the_longest_allowed(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    sessions = [
        session_of(tmp_path / "a.mcap", [0, 1000]),
        session_of(tmp_path / "b.mcap", [3000, 4000]),
        session_of(tmp_path / "c.mcap", [3_600_000, 3_601_000]),
        session_of(tmp_path / "d.mcap", [500, 1500]),
    ]
    course = Course(sessions, longest_gap_s=10.0)
    assert play(course, listener.put, clock=clock) == 8
    expected = [0, 1, 3, 4, 14, 15, 15, 16]
    assert [round(time_ns / SECOND, 6) for time_ns in listener.after_ns] == expected
    assert [leg.gap_s for leg in course.legs] == [0.0, 2.0, 3596.0, -3600.5]
    assert listener.stamps_ms()[:3] == [5000, 6000, 8000]
    assert [course.leg(s * SECOND).session.path.name[0] for s in (0, 2.9, 3.1, 14.5, 99)] == [*"aabcd"]


def test_a_part_in_which_nothing_came_is_passed_over(tmp_path: Path) -> None:
    sessions = [
        session_of(tmp_path / "a.mcap", []),
        session_of(tmp_path / "b.mcap", [0, 1000]),
        session_of(tmp_path / "c.mcap", []),
    ]
    course = Course(sessions)
    assert [leg.session.path.name for leg in course.legs] == ["b.mcap"]
    assert course.passed_over == [sessions[0], sessions[2]]


def test_other_topics_keep_their_place_between_the_samples(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 10, 20], arrivals_ms=[3, 12, 25])
    course = Course([session], (SURFACE_TORQUE, BIT_SPEED))
    assert play(course, listener.put, clock=clock) == 6
    assert listener.topics == [SURFACE_TORQUE, BIT_SPEED] * 3
    assert listener.after_ns == [0, 0, 10 * MS, 10 * MS, 20 * MS, 20 * MS]


@given(st.lists(st.integers(0, 4000), min_size=2, max_size=60), st.floats(0, 70), st.floats(0, 70))
@settings(max_examples=30)
def test_what_is_read_from_the_middle_is_what_lies_there(
    tmp_path_factory: pytest.TempPathFactory, steps: list[int], start_s: float, more_s: float
) -> None:
    times = [sum(steps[:n]) for n in range(len(steps))]
    session = session_of(tmp_path_factory.mktemp("middle") / "a.mcap", times, sync_each=3)
    course = Course([session])
    everything = list(course.between(0, math.inf))
    start_ns, end_ns = start_s * SECOND, (start_s + more_s) * SECOND
    wanted = [placed for placed in everything if start_ns <= placed.position_ns < end_ns]
    assert list(course.between(start_ns, end_ns)) == wanted
    assert [placed.position_ns for placed in everything] == [time * MS for time in times]


def test_both_channels_are_played(tmp_path: Path) -> None:
    with SessionWriter(tmp_path / "a.mcap", configuration="", metadata={}, compression="none") as writer:
        for topic in (SURFACE_TORQUE, SURFACE_SPEED):
            writer.write(topic, Sample(time_ns=1, value=2).SerializeToString(), 1, 1)
    clock = FakeClock()
    listener = Listener(clock)
    play(Course([Session(tmp_path / "a.mcap")]), listener.put, clock=clock)
    assert listener.topics == [SURFACE_TORQUE, SURFACE_SPEED]
    assert not listener.samples[0].HasField("sequence")
