"""A session played: each sample at its time, by any clock, once or over and over."""

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path

import pytest

from vsensor.errors import InputError
from vsensor.messages import BIT_SPEED, SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.recording.player import Command, play
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

MS = 1_000_000
SECOND = 1000 * MS


class FakeClock:
    """Time passes only by sleeping (and oversleeping), and by work between."""

    def __init__(self, overshoot_ns: int = 0) -> None:
        self.time_ns = 777 * SECOND
        self.overshoot_ns = overshoot_ns

    def now_ns(self) -> int:
        return self.time_ns

    def sleep_until(self, time_ns: int) -> None:
        self.time_ns = max(self.time_ns, time_ns + self.overshoot_ns)


class Listener:
    """Notes what came, and when after the first."""

    def __init__(self, clock: FakeClock, work_ns: int = 0) -> None:
        self._clock = clock
        self._work_ns = work_ns
        self.topics: list[str] = []
        self.samples: list[Sample] = []
        self.times_ns: list[int] = []

    def put(self, topic: str, sample: Sample) -> None:
        self.topics.append(topic)
        self.samples.append(sample)
        self.times_ns.append(self._clock.time_ns)
        self._clock.time_ns += self._work_ns

    @property
    def after_ns(self) -> list[int]:
        return [time_ns - self.times_ns[0] for time_ns in self.times_ns]

    def stamps_ms(self) -> list[float]:
        return [sample.time_ns / MS for sample in self.samples]


def session_of(
    path: Path,
    times_ms: Iterable[float],
    arrivals_ms: Iterable[float] | None = None,
    start_ns: int = 5 * SECOND,
) -> Session:
    start_ns = 5 * SECOND
    times = [start_ns + round(time * MS) for time in times_ms]
    arrivals = times if arrivals_ms is None else [start_ns + round(time * MS) for time in arrivals_ms]
    with SessionWriter(path, configuration="", metadata={"rig": "r"}, compression="none") as writer:
        for number, (time_ns, arrival_ns) in enumerate(zip(times, arrivals, strict=True)):
            sample = Sample(time_ns=time_ns, value=number, sequence=100 + number)
            writer.write(SURFACE_TORQUE, sample.SerializeToString(), arrival_ns, time_ns)
            writer.write(BIT_SPEED, sample.SerializeToString(), arrival_ns, time_ns)
    return Session(path)


def after(clock: FakeClock, script: dict[int, Command]) -> Callable[[], Command | None]:
    """A listener at the keyboard who gives each command once, that many ns after the start."""
    start_ns = clock.time_ns
    waiting = sorted(script.items())

    def command() -> Command | None:
        if waiting and clock.time_ns - start_ns >= waiting[0][0]:
            return waiting.pop(0)[1]
        return None

    return command


def test_samples_come_at_the_spacing_of_their_own_times(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    count = play(session_of(tmp_path / "a.mcap", [0, 10, 20, 1020]), listener.put, clock=clock)
    assert count == 4
    assert listener.after_ns == [0, 10 * MS, 20 * MS, 1020 * MS]
    assert listener.stamps_ms() == [5000, 5010, 5020, 6020]
    assert set(listener.topics) == {SURFACE_TORQUE}


@pytest.mark.parametrize("speed", [0.5, 1.0, 3.0, 20.0])
def test_oversleeping_and_work_never_add_up(tmp_path: Path, speed: float) -> None:
    clock = FakeClock(overshoot_ns=300_000)
    listener = Listener(clock, work_ns=100_000)
    session = session_of(tmp_path / "a.mcap", [10 * n for n in range(500)])
    play(session, listener.put, clock=clock, speed=speed)
    start_ns = listener.times_ns[0]
    for number, time_ns in enumerate(listener.times_ns[1:], 1):
        late_ns = time_ns - start_ns - 10 * MS * number / speed
        assert 0 <= late_ns <= 400_001


def test_what_is_late_goes_out_at_once(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)

    def put(topic: str, sample: Sample) -> None:
        listener.put(topic, sample)
        if len(listener.samples) == 2:
            clock.time_ns += 35 * MS  # the bus held us up

    play(session_of(tmp_path / "a.mcap", [0, 10, 20, 30, 40, 50, 60]), put, clock=clock)
    assert listener.after_ns == [0, 10 * MS, 45 * MS, 45 * MS, 45 * MS, 50 * MS, 60 * MS]


def test_samples_out_of_order_stay_so(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 20, 10, 30], arrivals_ms=[0, 20, 21, 30])
    play(session, listener.put, clock=clock)
    assert listener.stamps_ms() == [5000, 5020, 5010, 5030]
    assert listener.after_ns == [0, 20 * MS, 20 * MS, 30 * MS]


def test_one_wild_stamp_does_not_hold_the_player_up(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 10, 1e12, 30, 40], arrivals_ms=[0, 10, 20, 30, 40])
    play(session, listener.put, clock=clock)
    assert listener.after_ns == [0, 10 * MS, 20 * MS, 30 * MS, 40 * MS]


def test_start_and_duration_pick_a_piece(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [10 * n for n in range(300)])
    count = play(session, listener.put, clock=clock, start_s=1.0, duration_s=0.5)
    assert count == 50
    assert listener.stamps_ms()[0] == 6000
    assert listener.after_ns[-1] == 490 * MS


@pytest.mark.parametrize("start_s", [1.0, math.inf])
def test_nothing_to_play_is_an_error(tmp_path: Path, start_s: float) -> None:
    clock = FakeClock()
    session = session_of(tmp_path / "a.mcap", [0, 10])
    with pytest.raises(InputError, match=r"a\.mcap: holds no surface/torque and no surface/speed between"):
        play(session, Listener(clock).put, clock=clock, start_s=start_s)


def test_present_stamps_keep_their_spacing(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 10, 25])
    play(session, listener.put, clock=clock, speed=5.0, first_time_ns=10**18)
    assert [sample.time_ns - 10**18 for sample in listener.samples] == [0, 10 * MS, 25 * MS]


def test_a_loop_runs_on_in_time_and_sequence(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 10, 20])
    count = play(session, listener.put, clock=clock, loop=True, command=after(clock, {95 * MS: Command.QUIT}))
    assert count == 10
    assert listener.after_ns == [10 * MS * n for n in range(10)]
    assert listener.stamps_ms() == [5000 + 10 * n for n in range(10)]
    assert [sample.sequence for sample in listener.samples] == [100 + n for n in range(10)]


def test_a_looped_piece_never_turns_time_back(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 10, 20, 33, 41, 60])
    stop = after(clock, {SECOND: Command.QUIT})
    play(session, listener.put, clock=clock, loop=True, start_s=0.01, duration_s=0.04, command=stop)
    assert len(listener.samples) > 50
    assert all(one < other for one, other in pairwise(listener.stamps_ms()))
    assert all(one < other for one, other in pairwise(listener.after_ns))


def test_a_pause_holds_and_the_rest_keeps_its_spacing(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 1000, 2000, 3000])
    script = {1200 * MS: Command.PAUSE, 5200 * MS: Command.PAUSE}
    play(session, listener.put, clock=clock, command=after(clock, script))
    assert listener.after_ns == [0, SECOND, 6 * SECOND, 7 * SECOND]


def test_paused_each_step_gives_one_sample(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 1000, 2000, 3000, 4000])
    script = {
        100 * MS: Command.PAUSE,
        500 * MS: Command.STEP,
        600 * MS: Command.STEP,
        10 * SECOND: Command.PAUSE,
    }
    play(session, listener.put, clock=clock, command=after(clock, script))
    assert listener.after_ns == [0, 500 * MS, 600 * MS, 11 * SECOND, 12 * SECOND]


def test_a_step_while_playing_does_nothing(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 1000])
    play(session, listener.put, clock=clock, command=after(clock, {100 * MS: Command.STEP}))
    assert listener.after_ns == [0, SECOND]


def test_quitting_ends_a_long_wait_soon(tmp_path: Path) -> None:
    clock = FakeClock()
    listener = Listener(clock)
    session = session_of(tmp_path / "a.mcap", [0, 3_600_000])
    start_ns = clock.time_ns
    count = play(session, listener.put, clock=clock, command=after(clock, {SECOND: Command.QUIT}))
    assert count == 1
    assert clock.time_ns - start_ns < 1.1 * SECOND


def test_both_channels_are_played(tmp_path: Path) -> None:
    with SessionWriter(tmp_path / "a.mcap", configuration="", metadata={}, compression="none") as writer:
        for topic in (SURFACE_TORQUE, SURFACE_SPEED):
            writer.write(topic, Sample(time_ns=1, value=2).SerializeToString(), 1, 1)
    clock = FakeClock()
    listener = Listener(clock)
    play(Session(tmp_path / "a.mcap"), listener.put, clock=clock)
    assert listener.topics == [SURFACE_TORQUE, SURFACE_SPEED]
    assert not listener.samples[0].HasField("sequence")
