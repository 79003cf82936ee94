"""The daemon under load: with recording, with the view, with both, with a busy neighbour.

In turn with it a bare loop in C, at the same priority if the daemon has one, and under the same load: that is
beside the daemon, which is measured without it. In the daemon's own turns a bare Zenoh echo.
"""

import json
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import zenoh

from vsensor import demo
from vsensor.bench.processes import processor_s, resident_bytes
from vsensor.bench.served import served
from vsensor.bench.wakes import Wakes, all_of, bare_loop
from vsensor.bus import ask_status, command, open_session
from vsensor.config import Rig, effective_toml
from vsensor.errors import VsensorError
from vsensor.messages import Status
from vsensor.service.histogram import quantile_s

ESTIMATE_BYTES = 180
WARM_S = 4.0
"""Before the first load, and between two: what begins or ends has its own cost."""
TURN_S = 10.0
"""So long runs each of the two, or less, until the other has its turn."""
STATUS_S = 1.0
"""What the daemon tells of itself is as old as this at most."""
SPIN = "while True: pass"


class Load(NamedTuple):
    """What runs besides rig and daemon."""

    name: str
    recording: bool = False
    view: bool = False
    busy: bool = False


LOADS = (
    Load("nothing"),
    Load("recording", recording=True),
    Load("view", view=True),
    Load("recording and view", recording=True, view=True),
    Load("both, and a busy neighbour", recording=True, view=True, busy=True),
)


class Measured(NamedTuple):
    """One load at one rate."""

    rate_hz: float
    load: Load
    lateness_s: tuple[float, float]
    """Median and 99 %."""
    due: int
    skipped: int
    bare: Wakes | None
    """The loop in C; None without a compiler."""
    latency: dict[str, list[float]]
    processor: float
    """Share of one core that the daemon took."""
    memory: list[tuple[float, int]]
    """Seconds since the daemon was ready, and bytes that it held, at the end of each turn."""
    kept_awake: bool
    """Whether the daemon kept the processors from their idle states, for itself and for all beside it."""

    @property
    def condition(self) -> str:
        """That, in words."""
        return f"processors {'kept' if self.kept_awake else 'not kept'} from idle states"


def _in_real_time(rig: Rig) -> Rig:
    asked = {"realtime": "prefer", "stay_awake": True}
    return rig.model_copy(update={"loop": rig.loop.model_copy(update=asked)})


def under_loads(
    rig: Rig,
    base: Path,
    bare: Path | None,
    seconds: float,
    say: Callable[[str], None],
    loads: Sequence[Load],
) -> Iterator[Measured]:
    """Run one daemon, with real-time priority if granted, under each load in turn.

    `bare` is the compiled loop that has its turns between the daemon's, `seconds` each in all.
    Raises VsensorError where a process fails.
    """
    folder = Path(tempfile.mkdtemp(dir=base))
    rig = _in_real_time(rig)
    recording = rig.recording.model_copy(update={"enabled": False, "folder": folder})
    rig = demo.on_free_port(rig.model_copy(update={"recording": recording}))
    config = folder / "rig.toml"
    config.write_text(effective_toml(rig), encoding="utf-8")
    say(f"the daemon starts at {rig.loop.rate:g} Hz")
    with ExitStack() as running:
        daemon = running.enter_context(demo.process("run", str(config)))
        demo.await_ready(daemon)
        ready = time.monotonic()
        probe = running.enter_context(_probe(config))
        session = running.enter_context(open_session(rig.bus, "client"))
        time.sleep(WARM_S)
        for load in loads:
            say(f"{rig.loop.rate:g} Hz with {load.name} for {seconds:g} s")
            with _loaded(rig, config, session, load):
                time.sleep(WARM_S)
                yield _measure(Sensor(rig, daemon.pid, ready, session, probe), load, bare, seconds)


class Sensor(NamedTuple):
    """The daemon at work, and whom to ask about it."""

    rig: Rig
    pid: int
    ready_s: float
    session: zenoh.Session
    probe: Callable[[], dict[str, list[float]]]
    """Latencies since it was last asked."""


def _measure(sensor: Sensor, load: Load, bare: Path | None, seconds: float) -> Measured:
    count = max(1, round(seconds / TURN_S))
    own: list[Turn] = []
    others: list[Wakes] = []
    for _ in range(count):
        own.append(_turn(sensor, seconds / count))
        if bare:
            scheduling = own[-1].after.scheduling
            with bare_loop(bare, sensor.rig.loop.rate, seconds / count, scheduling) as wakes:
                others.append(wakes())
    counts = np.sum([turn.counts for turn in own], axis=0).tolist()
    return Measured(
        sensor.rig.loop.rate,
        load,
        (quantile_s(counts, 0.5), quantile_s(counts, 0.99)),
        sum(turn.after.slots_due - turn.before.slots_due for turn in own),
        sum(turn.after.slots_skipped - turn.before.slots_skipped for turn in own),
        all_of(others) if others else None,
        {part: [each for turn in own for each in turn.latency[part]] for part in own[0].latency},
        float(np.mean([turn.processor for turn in own])),
        [turn.memory for turn in own],
        own[-1].after.kept_awake,
    )


class Turn(NamedTuple):
    """What the daemon did while no bare loop ran."""

    before: Status
    after: Status
    latency: dict[str, list[float]]
    processor: float
    memory: tuple[float, int]

    @property
    def counts(self) -> list[int]:
        """How many wake-ups were as late as each class of the histogram."""
        both = zip(self.after.lateness.counts, self.before.lateness.counts, strict=True)
        return [now - then for now, then in both]


def _turn(sensor: Sensor, seconds: float) -> Turn:
    time.sleep(STATUS_S)
    sensor.probe()
    before, took, begun = _status(sensor), processor_s(sensor.pid), time.monotonic()
    time.sleep(seconds)
    processor = (processor_s(sensor.pid) - took) / (time.monotonic() - begun)
    latency = sensor.probe()
    time.sleep(STATUS_S)
    memory = time.monotonic() - sensor.ready_s, resident_bytes(sensor.pid)
    return Turn(before, _status(sensor), latency, processor, memory)


def _status(sensor: Sensor) -> Status:
    return ask_status(sensor.session, sensor.rig.prefix)


@contextmanager
def _loaded(rig: Rig, config: Path, session: zenoh.Session, load: Load) -> Iterator[None]:
    with ExitStack() as running:
        if load.recording:
            command(session, rig.prefix, "start recording")
            running.callback(command, session, rig.prefix, "stop recording")
        if load.view:
            running.enter_context(served(config, config.parent / f"{time.monotonic_ns()}.rrd"))
        if load.busy:
            running.enter_context(_process("-c", SPIN))
        yield


@contextmanager
def _probe(config: Path) -> Iterator[Callable[[], dict[str, list[float]]]]:
    """The timing rig and its echo; yields what asks for a report."""
    with socket.socket() as door:
        door.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{door.getsockname()[1]}"
    with (
        _process("-m", "vsensor.bench.echo", endpoint, str(ESTIMATE_BYTES)) as echo,
        ExitStack() as later,
    ):
        _line(echo)
        probe = later.enter_context(_process("-m", "vsensor.bench.probe", str(config), endpoint))

        def ask() -> dict[str, list[float]]:
            if probe.stdin is None:
                raise VsensorError("the probe has no standard input")
            probe.stdin.write("\n")
            probe.stdin.flush()
            report: dict[str, list[float]] = json.loads(_line(probe))
            return report

        ask()
        yield ask


@contextmanager
def _process(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [sys.executable, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as running:
        try:
            yield running
        finally:
            running.kill()


def _line(process: subprocess.Popen[str]) -> str:
    line = process.stdout.readline() if process.stdout else ""
    if not line:
        raise VsensorError(f"{process.args!r} ended with status {process.poll()}")
    return line
