"""The sensor on time under load: with recording, with the view, with both, with a busy neighbour.

Beside each run a bare loop in C, at the same priority if the daemon has one, and a bare Zenoh echo.
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
from vsensor.bench.compiler import NO_COMPILER, compiler
from vsensor.bench.live import rig_at
from vsensor.bench.processes import processor_s, resident_bytes
from vsensor.bench.table import Cell, Table
from vsensor.bench.wakes import Wakes, bare_loop, build_bare_loop
from vsensor.bus import ask_status, command, open_session
from vsensor.config import Rig, effective_toml
from vsensor.errors import VsensorError
from vsensor.service.histogram import quantile_s

ESTIMATE_BYTES = 180
WARM_S = 4.0
"""Before the first load, and between two: what begins or ends has its own cost."""
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
    beside: Wakes | None
    latency: dict[str, list[float]]
    processor: float
    """Share of one core that the daemon took."""
    resident: tuple[int, int]
    """Bytes of the daemon's memory, before and after."""
    seconds: float
    kept_awake: bool
    """Whether the daemon kept the processors from their idle states, for itself and for all beside it."""

    @property
    def condition(self) -> str:
        """That, in words."""
        return f"processors {'kept' if self.kept_awake else 'not kept'} from idle states"


def tables(rates_hz: Sequence[float], seconds: float, say: Callable[[str], None]) -> Iterator[Table]:
    """Run the demonstration's daemon at each rate and under each load, with real-time priority if granted.

    Raises VsensorError where a process fails.
    """
    rigs = [rig_at(rate) for rate in rates_hz]
    cc = compiler()
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as name:
        bare = build_bare_loop(cc, Path(name)) if cc else None
        measured = [one for rig in rigs for one in under_loads(rig, Path(name), bare, seconds, say, LOADS)]
    yield _lateness(measured)
    yield _latency(measured)
    yield _cost(measured)


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

    `bare` is the compiled loop to run beside it. Raises VsensorError where a process fails.
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
        ask = running.enter_context(_probe(config))
        session = running.enter_context(open_session(rig.bus, "client"))
        time.sleep(WARM_S)
        for load in loads:
            say(f"{rig.loop.rate:g} Hz with {load.name} for {seconds:g} s")
            with _loaded(rig, config, session, load):
                time.sleep(WARM_S)
                yield _measure(rig, load, daemon.pid, session, ask, bare, seconds)


def _measure(
    rig: Rig,
    load: Load,
    pid: int,
    session: zenoh.Session,
    ask: Callable[[], dict[str, list[float]]],
    bare: Path | None,
    seconds: float,
) -> Measured:
    ask()
    before, took, held = ask_status(session, rig.prefix), processor_s(pid), resident_bytes(pid)
    begun = time.monotonic()
    if bare:
        with bare_loop(bare, rig.loop.rate, seconds, before.scheduling) as wakes:
            beside = wakes()
    else:
        time.sleep(seconds)
        beside = None
    lasted = time.monotonic() - begun
    time.sleep(1.0)  # the status of the last second
    after = ask_status(session, rig.prefix)
    counts = [now - then for now, then in zip(after.lateness.counts, before.lateness.counts, strict=True)]
    return Measured(
        rig.loop.rate,
        load,
        (quantile_s(counts, 0.5), quantile_s(counts, 0.99)),
        after.slots_due - before.slots_due,
        after.slots_skipped - before.slots_skipped,
        beside,
        ask(),
        (processor_s(pid) - took) / (lasted + 1.0),
        (held, resident_bytes(pid)),
        lasted,
        after.kept_awake,
    )


@contextmanager
def _loaded(rig: Rig, config: Path, session: zenoh.Session, load: Load) -> Iterator[None]:
    with ExitStack() as running:
        if load.recording:
            command(session, rig.prefix, "start recording")
            running.callback(command, session, rig.prefix, "stop recording")
        if load.view:
            saved = config.parent / f"{time.monotonic_ns()}.rrd"
            running.enter_context(demo.process("view", str(config), "--save", str(saved)))
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


def _lateness(measured: Sequence[Measured]) -> Table:
    return Table(
        "Loads: how late each turn wakes",
        (
            *("loop and load", "median, µs", "99 %, µs", "skipped, ‰"),
            *("C 50 %", "C 99 %", "C missed, ‰", "ratio 50 %", "ratio 99 %"),
        ),
        tuple(_lateness_row(one) for one in measured),
        (
            "C: a bare loop on the same grid in the same seconds, with the daemon's scheduling"
            if any(one.beside for one in measured)
            else NO_COMPILER,
            measured[0].condition,
        ),
    )


def _lateness_row(one: Measured) -> tuple[Cell, ...]:
    own = tuple(1e6 * each for each in one.lateness_s)
    name = f"{one.rate_hz:g} Hz, {one.load.name}"
    if one.beside is None:
        return (name, *own, 1000 * one.skipped / one.due, None, None, None, None, None)
    other = tuple(one.beside.percentile_us(share) for share in (50, 99))
    return (
        name,
        *own,
        1000 * one.skipped / one.due,
        *other,
        1000 * one.beside.skipped / one.beside.due,
        *(mine / its for mine, its in zip(own, other, strict=True)),
    )


def _latency(measured: Sequence[Measured]) -> Table:
    return Table(
        "Loads: from a sample put to its estimate received in another process",
        ("loop and load", "whole, µs", "behind the wake-up, µs", "echo, µs", "echo 99 %, µs", "ratio"),
        tuple(_latency_row(one) for one in measured),
        (
            "medians; the echo is a bare one over Zenoh, there and back, in the same seconds; ratio: what "
            "lies beyond the wait for the tick (half an echo there, all behind the wake-up) over the echo",
        ),
    )


def _latency_row(one: Measured) -> tuple[Cell, ...]:
    name = f"{one.rate_hz:g} Hz, {one.load.name}"
    if not all(one.latency.values()):
        return (name, None, None, None, None, None)
    whole, behind, echo = (float(np.median(one.latency[part])) / 1e3 for part in ("whole", "behind", "echo"))
    worst = float(np.percentile(one.latency["echo"], 99)) / 1e3
    return name, whole, behind, echo, worst, (behind + echo / 2) / echo


def _cost(measured: Sequence[Measured]) -> Table:
    return Table(
        "Loads: what the daemon takes",
        ("loop and load", "of one core, %", "memory, MB", "grown, kB"),
        tuple(
            (
                f"{one.rate_hz:g} Hz, {one.load.name}",
                100 * one.processor,
                one.resident[1] / 1e6,
                (one.resident[1] - one.resident[0]) / 1e3,
            )
            for one in measured
        ),
        (f"over {measured[0].seconds:.0f} s each; a run of minutes tells a slope",),
    )
