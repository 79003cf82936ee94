"""`vsensor replay` on a real bus: every sample arrives, and the keyboard is obeyed."""

import os
import re
import signal
import socket
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest
import zenoh
from typer.testing import CliRunner

from tests.players import Terminal
from vsensor.bus import Questions, SurfaceInbox, open_session
from vsensor.cli.main import app
from vsensor.config import Bus
from vsensor.messages import SENSOR_ALIVE, SENSOR_EVENT, SURFACE_SPEED, SURFACE_TORQUE, Event, Sample
from vsensor.recording.writer import SessionWriter

pytestmark = pytest.mark.process

ROWS = 3000
NS = 1_000_000_000
PREFIX = "rigs/well-b"
# A terminal of its own, as a shell would give it.
ON_A_TERMINAL = (
    "import fcntl, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); from vsensor.cli.main import main; main()"
)


COMMANDS = f"{PREFIX}/sensor/command"


class Rig:
    """The daemon's ears on a bus of our own."""

    def __init__(self, zenoh_session: zenoh.Session, endpoint: str) -> None:
        self.endpoint = endpoint
        self.samples: list[tuple[str, Sample]] = []
        self._inbox = SurfaceInbox(zenoh_session, PREFIX, (SURFACE_TORQUE, SURFACE_SPEED))
        self.told: list[str] = []
        self._questions = Questions(zenoh_session, COMMANDS)
        self._alive = zenoh_session.liveliness().declare_token(f"{PREFIX}/{SENSOR_ALIVE}")

    def hear(self) -> int:
        """Take in what has come; how many samples that makes."""
        self._questions.answer(self._obey)
        return self._take_in()

    def _take_in(self) -> int:
        for received in self._inbox.drain():
            assert received.sample is not None
            self.samples.append((received.topic, received.sample))
        return len(self.samples)

    def _obey(self, words: str) -> str:
        if words == "nonsense":
            raise ValueError("is no command")
        self.told.append(f"{self._take_in()} {words}")  # the player waits: no more has been sent
        return "done"

    def until(self, true: Callable[[], bool], seconds: float = 40.0) -> None:
        deadline = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < deadline, "did not happen in time"
            self.hear()
            time.sleep(0.01)

    def until_silent(self) -> None:
        """Wait until nothing has come for a while (samples of the session are 10 ms apart)."""
        heard, since = -1, time.monotonic()
        while time.monotonic() - since < 0.5:
            if self.hear() != heard:
                heard, since = self.hear(), time.monotonic()
            time.sleep(0.01)


@pytest.fixture
def rig() -> Iterator[Rig]:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    with open_session(Bus(listen=(endpoint,)), "daemon") as session:
        yield Rig(session, endpoint)


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    path = tmp_path / "a.mcap"
    write(path, ROWS)
    return path


def write(
    path: Path,
    rows: int,
    begun_ns: int = 1000 * NS,
    events: Mapping[int, str] | None = None,
    rig: str = "well-b",
) -> None:
    with SessionWriter(path, configuration="", metadata={"rig": rig}, compression="zstd") as writer:
        for number in range(rows):
            time_ns = begun_ns + number * 10_000_000
            if events and number in events:
                event = Event(time_ns=time_ns, name="command", begins=True, text=events[number])
                writer.write(SENSOR_EVENT, event.SerializeToString(), time_ns, time_ns)
            for topic in (SURFACE_TORQUE, SURFACE_SPEED):
                sample = Sample(time_ns=time_ns, value=number, sequence=number)
                writer.write(topic, sample.SerializeToString(), time_ns, time_ns)


def replay(rig: Rig, session: Path, *words: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "vsensor.cli.main", "replay", session, "--connect", rig.endpoint, *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_every_sample_of_the_piece_arrives_from_the_very_first(rig: Rig, recorded: Path) -> None:
    with replay(rig, recorded, "--speed", "50", "--start", "10", "--duration", "15") as player:
        rig.until(lambda: rig.hear() >= 3000)
        said, complained = player.communicate(timeout=30)

    assert (player.returncode, complained) == (0, "")
    assert f"3000 samples of {recorded} published on {PREFIX}" in said
    for channel in (SURFACE_TORQUE, SURFACE_SPEED):  # which of two that come at once is heard first is chance
        heard = [sample for topic, sample in rig.samples if topic == channel]
        assert [sample.sequence for sample in heard] == list(range(1000, 2500))
        assert heard[0].time_ns == 1010 * NS


def test_present_stamps_begin_now(rig: Rig, recorded: Path) -> None:
    before = time.time_ns()
    with replay(rig, recorded, "--duration", "0.1", "--present") as player:
        rig.until(lambda: rig.hear() == 20)
        player.communicate(timeout=30)

    times = [sample.time_ns for _, sample in rig.samples[::2]]
    assert before < times[0] < time.time_ns()
    assert [time_ns - times[0] for time_ns in times] == [10_000_000 * n for n in range(10)]


def test_until_and_as_fast_as_it_goes(rig: Rig, recorded: Path) -> None:
    with replay(rig, recorded, "--speed", "max", "--start", "5", "--until", "12") as player:
        rig.until(lambda: rig.hear() == 1400)
        player.communicate(timeout=30)
    assert player.returncode == 0
    assert rig.samples[-1][1].time_ns == 1011 * NS + 990_000_000


def test_several_sessions_in_a_row_tell_their_gap(rig: Rig, recorded: Path, tmp_path: Path) -> None:
    later = tmp_path / "b.mcap"
    write(later, 50, begun_ns=1030 * NS + 90 * NS)
    words = ("--speed", "100", "--topics", SURFACE_SPEED, "--start", "29")
    with replay(rig, recorded, str(later), *words) as player:
        rig.until(lambda: rig.hear() == 150)
        said, complained = player.communicate(timeout=30)
    assert f"{later}, after a gap of 1:30.0" in complained.replace("\n", "")
    assert f"150 messages of {recorded}, {later} published" in said
    assert {topic for topic, _ in rig.samples} == {SURFACE_SPEED}


def test_recorded_commands_are_given_again_at_their_place_if_asked(rig: Rig, tmp_path: Path) -> None:
    path = tmp_path / "c.mcap"
    events = {30: "off bottom", 31: "nonsense", 60: "longer 28.5 m"}
    write(path, 100, events=events)
    with replay(rig, path, "--commands") as player:
        rig.until(lambda: rig.hear() == 200)
        _, complained = player.communicate(timeout=30)
    assert player.returncode == 0
    assert rig.told == ["60 off bottom", "120 longer 28.5 m"]
    assert '"off bottom": done' in complained
    assert '"nonsense" is refused: is no command' in complained
    with replay(rig, path) as player:
        rig.until(lambda: rig.hear() == 400)
        player.communicate(timeout=30)
    assert len(rig.told) == 2


def test_each_lap_of_a_loop_begins_with_the_string_and_the_bit_as_they_were(rig: Rig, tmp_path: Path) -> None:
    path = tmp_path / "c.mcap"
    write(path, 100, events={20: "longer 28.5 m", 30: "off bottom", 40: "nonsense", 60: "longer 1000 cm"})
    with replay(rig, path, "--commands", "--loop", "--speed", "4") as player:
        rig.until(lambda: len(rig.told) >= 8)
        player.send_signal(signal.SIGINT)
        player.communicate(timeout=30)
    assert rig.told[:8] == [
        *("40 longer 28.5 m", "60 off bottom", "120 longer 1000 cm"),
        # By no more at a time than was obeyed: a sensor refuses what is no connection.
        *("200 shorter 28.5 m", "200 shorter 10.0 m", "200 by depths"),
        *("240 longer 28.5 m", "260 off bottom"),
    ]


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (("--speed", "0"), "is no speed"),
        (("--speed", "quick"), "is no speed"),
        (("--speed", "1e308"), "is no speed"),
        (("--topics", "surface/colour"), "is on no bus"),
        (("--topics", "sensor/state"), "is on no bus"),
        (("--topics", "bit/estimate"), "holds none of bit/estimate"),
    ],
)
def test_what_cannot_be_played_is_named(recorded: Path, words: tuple[str, ...], fault: str) -> None:
    done = CliRunner().invoke(app, ["replay", str(recorded), *words])
    assert done.exit_code in (1, 2)
    assert fault in done.output


def test_sessions_of_two_rigs_are_not_mixed_unless_a_name_is_given(recorded: Path, tmp_path: Path) -> None:
    write(tmp_path / "d.mcap", 10, rig="well-c")
    done = CliRunner().invoke(app, ["replay", str(recorded), str(tmp_path / "d.mcap")])
    assert done.exit_code == 2
    assert "is not of the rig well-b" in done.output


def test_ctrl_c_ends_an_endless_loop_with_its_account(rig: Rig, recorded: Path) -> None:
    with replay(rig, recorded, "--loop", "--duration", "0.2") as player:
        rig.until(lambda: rig.hear() > 60)
        player.send_signal(signal.SIGINT)
        said, _ = player.communicate(timeout=30)

    assert player.returncode == 0
    assert "published on rigs/well-b" in said
    rig.hear()
    sequences = [sample.sequence for topic, sample in rig.samples if topic == SURFACE_TORQUE]
    assert sequences == list(range(len(sequences)))


def test_at_a_terminal_the_line_tells_where_it_is_and_the_keys_are_obeyed(rig: Rig, recorded: Path) -> None:
    terminal = Terminal()
    before = termios.tcgetattr(terminal.theirs)
    player = subprocess.Popen(
        [sys.executable, "-c", ON_A_TERMINAL, "replay", recorded, "--connect", rig.endpoint],
        stdin=terminal.theirs,
        stdout=subprocess.PIPE,
        stderr=terminal.theirs,
        env=os.environ | {"TERM": "xterm", "COLUMNS": "160"},
        text=True,
        start_new_session=True,
    )
    with player:
        rig.until(lambda: rig.hear() > 20)
        terminal.type(b" ")
        rig.until_silent()
        heard = rig.hear()
        rig.until(lambda: pausing(terminal, heard))
        terminal.type(b"...")
        rig.until(lambda: rig.hear() == heard + 3)
        rig.until_silent()
        assert rig.hear() == heard + 3
        rig.until(lambda: pausing(terminal, heard + 3))
        terminal.type(b"\x1b[C")  # an arrow
        rig.until_silent()
        terminal.type(b".")
        rig.until(lambda: rig.hear() == heard + 4)
        assert rig.samples[-1][1].time_ns - rig.samples[-2][1].time_ns >= 10 * NS - 20_000_000
        terminal.type(b" ")
        rig.until(lambda: rig.hear() > heard + 20 and terminal.line().startswith("▶ 0:1"))
        terminal.type(b"q")
        said, _ = player.communicate(timeout=30)

    assert player.returncode == 0
    assert f"{rig.hear()} samples" in said
    assert termios.tcgetattr(terminal.theirs) == before
    terminal.close()


def pausing(terminal: Terminal, samples: int) -> bool:
    """Whether its line says that so many were published of a session of 30 s, and then no more."""
    what = rf"⏸ 0:00\.\d \S+ 0:30\.0  ×1  {samples} on {PREFIX}  \(space pauses, .* q ends\)"
    return re.fullmatch(what, terminal.line()) is not None
