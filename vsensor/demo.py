"""The demonstration: real processes over a real bus, and an account of how near the estimate came."""

import math
import os
import select
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.config import Rig, effective_toml
from vsensor.errors import VsensorError
from vsensor.estimator.severity import severity
from vsensor.messages import BIT_ESTIMATE, SENSOR_TICK, Estimate
from vsensor.recording.reader import Session
from vsensor.units import factor

READY_S = 300.0
"""The first start compiles the kernels: a minute or two on an idle machine."""
END_S = 30.0
RPM = factor("rad/s", "rpm")


class Played(NamedTuple):
    """What a demonstration leaves behind."""

    session: Path
    truth: Path


def example(name: str) -> Path:
    """One of our example configurations, in a checkout or as installed."""
    places = (Path(__file__).parent.parent / "config", Path(sys.prefix) / "share" / "vsensor" / "config")
    for place in places:
        if (place / name).is_file():
            return place / name
    raise VsensorError(
        f"the example {name} is neither in {places[0]} nor in {places[1]}: name a configuration"
    )


def on_free_port(rig: Rig) -> Rig:
    """The same rig on a port of its own and without a memory: a daemon at work here is left alone."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    bus = rig.bus.model_copy(update={"listen": (f"tcp/127.0.0.1:{port}",)})
    return rig.model_copy(update={"bus": bus, "state": rig.state.model_copy(update={"enabled": False})})


def how_to_view(*, web: bool, say: Callable[[str], None]) -> list[str]:
    """The view's own arguments: a window where there is a display, else the browser."""
    if web:
        return ["--web"]
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        say("the live view opens in a window of its own")
        return []
    say("there is no display here: the live view is served for a browser instead")
    return ["--web"]


def play(
    rig: Rig,
    folder: Path,
    scenario: str,
    view: list[str] | None,
    seconds: float,
    say: Callable[[str], None],
    stopped: Callable[[], bool],
) -> Played:
    """Run rig, daemon and view as processes for `seconds` (0: until told to stop), then end them in order."""
    config = folder / "rig.toml"
    config.write_text(effective_toml(rig), encoding="utf-8")
    truth = folder / "truth.csv"
    before = set(rig.recording.folder.glob("*.mcap"))
    with ExitStack() as processes:
        daemon = processes.enter_context(process("run", str(config)))
        await_ready(daemon)
        if view is not None:
            processes.enter_context(process("view", str(config), *view, quiet=False))
        source = ["simulate", str(config), "--scenario", scenario, "--truth", str(truth)]
        rig_process = processes.enter_context(process(*source))
        _await_said(rig_process, b"Hz", "the rig", READY_S)
        say(
            f"a rig in {scenario} runs, and the sensor listens to it; "
            + (f"{seconds:g} s to go" if seconds else "Ctrl-C ends it")
        )
        _wait(seconds, stopped, {"run": daemon, "simulate": rig_process})
    recorded = set(rig.recording.folder.glob("*.mcap")) - before
    if not recorded:
        raise VsensorError(f"no session was recorded in {rig.recording.folder}")
    return Played(max(recorded, key=lambda path: path.stat().st_mtime), truth)


@contextmanager
def process(*arguments: str, quiet: bool = True) -> Iterator[subprocess.Popen[str]]:
    """Run one of our own commands; at the end it is ended by SIGTERM, and waited for.

    Not as by Ctrl-C: a process that is still importing may swallow Python's KeyboardInterrupt.
    """
    running = subprocess.Popen(
        [sys.executable, "-m", "vsensor.cli.main", *arguments],
        stdout=subprocess.PIPE if quiet else None,
        text=True,
        start_new_session=True,
    )
    try:
        yield running
    finally:
        if running.poll() is None:
            running.terminate()
        try:
            running.communicate(timeout=END_S)
        except subprocess.TimeoutExpired:
            running.kill()
            running.communicate()


def await_ready(daemon: subprocess.Popen[str], patience_s: float = READY_S) -> None:
    """Return when the daemon listens; VsensorError if it ends instead, or takes too long."""
    _await_said(daemon, b"READY", "the daemon", patience_s)


def _await_said(running: subprocess.Popen[str], word: bytes, who: str, patience_s: float) -> None:
    out = running.stdout.fileno() if running.stdout else -1
    said, end = b"", time.monotonic() + patience_s
    while (left_s := end - time.monotonic()) > 0 and select.select([out], [], [], left_s)[0]:
        if not (more := os.read(out, 1 << 16)):
            raise VsensorError(f"{who} ended before it was ready; it said why above")
        said += more
        if word in said:
            return
    raise VsensorError(f"{who} was not ready within {patience_s:g} s")


def _wait(seconds: float, stopped: Callable[[], bool], running: Mapping[str, subprocess.Popen[str]]) -> None:
    end = time.monotonic() + seconds if seconds else float("inf")
    while time.monotonic() < end and not stopped():
        for name, one in running.items():
            if one.poll() is not None:
                raise VsensorError(f"vsensor {name} ended with status {one.returncode}")
        time.sleep(0.1)


def account(rig: Rig, played: Played) -> str:
    """What the demonstration did, in words and figures."""
    session = Session(played.session)
    ticks = sum(1 for _ in session.messages((SENSOR_TICK,)))
    estimates = [r.message for r in session.messages((BIT_ESTIMATE,)) if isinstance(r.message, Estimate)]
    lines = [
        f"ticks               {ticks}",
        f"estimates published {len(estimates)}",
        f"session             {played.session}",
    ]
    speeds = np.array([e.confirmed_bit_speed_rad_s for e in estimates if e.HasField("confirmed_time_ns")])
    if len(speeds) == 0:
        return "\n".join([*lines, "too short for an answer: the waves need time to reach the bit and return"])
    window = speeds[-round(rig.estimator.severity_window * rig.loop.rate) :]
    worst = severity(window)
    lines += [
        f"bit speed           {speeds.min() * RPM:.0f} … {speeds.max() * RPM:.0f} rpm (confirmed)",
        f"severity            {'none: the bit rests' if math.isnan(worst) else f'{worst:.2f}'}"
        "  = (max − min) / (2 mean)"
        f" over the last {len(window) / rig.loop.rate:.0f} s; from 1 on the bit stops",
        "error against the simulated truth, rms:",
    ]
    truth = np.genfromtxt(played.truth, delimiter=",", names=True)
    return "\n".join([*lines, *(_error(kind, estimates, truth) for kind in ("confirmed", "now", "forecast"))])


def _error(kind: str, estimates: list[Estimate], truth: NDArray[np.void]) -> str:
    when = "time_ns" if kind == "now" else f"{kind}_time_ns"
    known = [e for e in estimates if e.HasField(f"{kind}_bit_speed_rad_s")]  # type: ignore[arg-type]
    times = np.array([getattr(e, when) / 1e9 for e in known])
    inside = (times >= truth["time_s"][0]) & (times <= truth["time_s"][-1])
    if not inside.any():
        return f"  {kind:<17} none yet that the truth could be held against"

    def rms(field: str, column: str) -> float:
        told = np.array([getattr(e, f"{kind}_bit_{field}") for e in known])[inside]
        return float(np.sqrt(np.mean((told - np.interp(times[inside], truth["time_s"], truth[column])) ** 2)))

    speed, torque = rms("speed_rad_s", "bit_speed_rad_s"), rms("torque_nm", "bit_torque_nm")
    return f"  {kind:<17} {speed * RPM:.1f} rpm, {torque / 1e3:.2f} kN·m"
