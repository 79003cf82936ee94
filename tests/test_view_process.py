"""`vsensor view` as it is used: it ends when told, leaves nothing behind, and survives its viewer."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from rerun.chunk import RrdReader

from tests.view_process import PATIENCE_S, children, free_port, gone, page, reachable, until
from tests.view_rig import messages
from vsensor.bus import Outbox, open_session
from vsensor.config import Bus
from vsensor.messages import SENSOR_TICK
from vsensor.recording.reader import Session
from vsensor.view.viewer import ending_with

pytestmark = pytest.mark.process


@pytest.fixture
def endpoint() -> Iterator[str]:
    """Where a small daemon publishes, over and over, until the test is over."""
    address = f"tcp/127.0.0.1:{free_port()}"
    over = threading.Event()
    with open_session(Bus(listen=(address,)), "daemon") as session:
        thread = threading.Thread(target=publish, args=(Outbox(session, "rigs/t", reliable=False), over))
        thread.start()
        yield address
        over.set()
        thread.join()


def publish(outbox: Outbox, over: threading.Event) -> None:
    while not over.is_set():
        begun_ns = time.time_ns()
        for topic, message in messages(500, begun_ns):
            outbox.put(topic, message)
            if over.wait(0.002):
                return


class View:
    """A running `vsensor view`, and what it says."""

    def __init__(self, *arguments: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "vsensor.cli.main", "view", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=os.environ | {"DISPLAY": "", "WAYLAND_DISPLAY": ""},
        )
        self.said: list[str] = []
        self._listener = threading.Thread(target=self._listen)
        self._listener.start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as words:
            self.said.extend(words)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        self._listener.join()

    def await_words(self, words: str) -> str:
        until(lambda: any(words in line for line in self.said) or self.process.poll() is not None)
        assert words in "".join(self.said)
        return "".join(self.said)

    def viewer(self) -> int:
        """The process id of the viewer that it has started."""
        (viewer,) = children(self.process.pid)
        return viewer

    def end(self, how: signal.Signals = signal.SIGINT) -> int:
        self.process.send_signal(how)
        return self.process.wait(PATIENCE_S)


@contextmanager
def view(*arguments: str, rig: Sequence[str] = ("--rig", "t")) -> Iterator[View]:
    running = View(*rig, *arguments)
    try:
        yield running
    finally:
        running.close()


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_a_file_is_complete_when_the_view_is_ended(
    endpoint: str, tmp_path: Path, how: signal.Signals
) -> None:
    file = tmp_path / "view.rrd"
    with view("--connect", endpoint, "--save", str(file)) as running:
        running.await_words("listening to rigs/t")
        begun = file.stat().st_size
        until(lambda: file.stat().st_size > begun + 150_000)
        assert running.end(how) == 0
    rows: dict[str, int] = {}
    with pytest.warns(match="no footer"):  # which a file that grows for days does without
        reader = RrdReader(file)
    for chunk in reader.stream():
        rows[chunk.entity_path] = rows.get(chunk.entity_path, 0) + chunk.num_rows
    assert rows["/speed/at_surface"] > 50
    assert rows["/speed/bit/now"] == rows["/torque/bit/now"] > 50
    assert rows["/glance"] > 1


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_the_page_is_served_to_this_machine_alone_and_ends_with_the_view(
    endpoint: str, how: signal.Signals
) -> None:
    with view(
        "--connect", endpoint, "--web", "--port", str(free_port()), "--data-port", str(free_port())
    ) as running:
        said = running.await_words("listening to rigs/t")
        url = re.findall(r"open (\S+)", said)[0]
        until(lambda: reachable(url))
        assert "<html" in page(url)
        viewer = running.viewer()
        assert {address for pid in (viewer, running.process.pid) for address in listening(pid)} == {
            "0100007F"
        }
        assert running.end(how) == 0
        assert gone(viewer)


def listening(pid: int) -> set[str]:
    """The addresses, as the kernel writes them, at which a process waits for connections."""
    inodes = {str(fd.readlink()) for fd in Path(f"/proc/{pid}/fd").iterdir() if fd.is_symlink()}
    found = set()
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/{pid}/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[3] == "0A" and f"socket:[{fields[9]}]" in inodes:
                found.add(fields[1].partition(":")[0])
    return found


def test_without_a_display_the_page_is_served_and_said_to_be(endpoint: str) -> None:
    with view("--connect", endpoint) as running:
        said = running.await_words("open http://127.0.0.1:")
        assert "no display" in said
        assert running.end() == 0


def test_a_killed_viewer_is_told_of_and_survived(endpoint: str) -> None:
    with view("--connect", endpoint, "--web") as running:
        running.await_words("listening to rigs/t")
        os.kill(running.viewer(), signal.SIGKILL)
        running.await_words("the viewer ended with status -9")
        assert running.process.poll() is None
        assert running.end() == 0


def test_a_view_that_is_killed_takes_its_viewer_with_it(endpoint: str) -> None:
    with view("--connect", endpoint, "--web") as running:
        running.await_words("listening to rigs/t")
        viewer = running.viewer()
        os.kill(running.process.pid, signal.SIGKILL)
        until(lambda: gone(viewer))


def test_a_viewer_whose_view_was_killed_before_it_could_be_tied_to_it_does_not_start() -> None:
    begun = [
        subprocess.run([*ending_with(parent), "echo", "begun"], capture_output=True, text=True, check=False)
        for parent in (os.getpid(), 1)
    ]
    assert [one.stdout for one in begun] == ["begun\n", ""]


def test_several_may_look_on_and_come_and_go(endpoint: str) -> None:
    with ExitStack() as looking:
        one = looking.enter_context(view("--connect", endpoint, "--web"))
        other = looking.enter_context(view("--connect", endpoint, "--web"))
        pages = re.findall(r"open (\S+)", one.await_words("listening to rigs/t"))
        pages += re.findall(r"open (\S+)", other.await_words("listening to rigs/t"))
        assert len({*pages}) == 2
        for pid in (one.process.pid, one.viewer()):
            assert os.getpriority(os.PRIO_PROCESS, pid) > os.getpriority(os.PRIO_PROCESS, 0)
        for url in pages:
            until(lambda: reachable(url))  # noqa: B023
        assert one.end() == 0
        assert other.process.poll() is None
        assert "<html" in page(pages[1])
        assert other.end() == 0


def test_a_frozen_viewer_holds_nothing_up(endpoint: str) -> None:
    with view("--connect", endpoint, "--web") as running:
        running.await_words("listening to rigs/t")
        viewer = running.viewer()
        os.kill(viewer, signal.SIGSTOP)
        assert running.end() == 0
        assert gone(viewer)


def test_without_a_daemon_it_says_so_and_waits_until_told_to_end() -> None:
    with view("--connect", f"tcp/127.0.0.1:{free_port()}", "--web") as running:
        running.await_words("is the daemon (vsensor run) up?")
        assert running.end() == 0


SESSION = "recordings/stick_slip.mcap"


def test_a_session_is_written_in_the_same_layout_with_everything_in_it(tmp_path: Path) -> None:
    file = tmp_path / "session.rrd"
    with view("--session", SESSION, "--save", str(file), rig=()) as running:
        assert running.process.wait(PATIENCE_S) == 0
    reader = RrdReader(file)
    assert reader.blueprints()
    rows: dict[str, int] = {}
    for chunk in reader.stream():
        rows[chunk.entity_path] = rows.get(chunk.entity_path, 0) + chunk.num_rows
    recorded = {topic.topic: topic.messages for topic in Session(Path(SESSION)).summary().topics}
    assert rows["/speed/at_surface"] >= recorded[SENSOR_TICK] > 1500
    for entity in ("/glance", "/string/twist/ribbon", "/string/torque/picture", "/rock/portrait/way/law"):
        assert rows[entity] > 5


def test_a_session_is_served_until_told_to_end() -> None:
    ports = ["--port", str(free_port()), "--data-port", str(free_port())]
    with view("--session", SESSION, "--web", *ports, rig=()) as running:
        url = re.findall(r"open (\S+)", running.await_words("open http"))[0]
        until(lambda: reachable(url))
        assert running.end() == 0


def test_a_session_without_estimates_is_refused_by_name(tmp_path: Path) -> None:
    table, session = tmp_path / "log.csv", tmp_path / "log.mcap"
    rows = [f"{number / 10},{7000 + number},10" for number in range(30)]
    table.write_text("\n".join(["time_s,motor_torque_nm,motor_speed_rad_s", *rows]))
    made = [sys.executable, "-m", "vsensor.cli.main", "import", str(table), "-o", str(session)]
    subprocess.run([*made, "--config", "config/drilling.toml"], check=True, capture_output=True)
    with view("--session", str(session), "--save", str(tmp_path / "x.rrd"), rig=()) as running:
        assert running.process.wait(PATIENCE_S) == 1
        running.await_words("holds no ticks of a sensor")


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        (["--connect", "nowhere"], "--connect"),
        (["--rig", "no/such name"], "--rig"),
        (["no-such-file.toml"], "no-such-file.toml"),
        (["--session", SESSION], "--rig and --connect are for a running sensor"),
        (["--torque-unit", "lbf"], "--torque-unit"),
    ],
)
def test_wrong_use_is_refused_with_what_would_be_right(arguments: list[str], fault: str) -> None:
    with view(*arguments) as running:
        assert running.process.wait(PATIENCE_S) == 2
        running.await_words(fault)
