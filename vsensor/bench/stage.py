"""One live run: rig, daemon and recorder as processes over a real bus, as in `vsensor demo`."""

import re
import subprocess
import time
from contextlib import nullcontext
from pathlib import Path
from typing import NamedTuple

from vsensor import demo
from vsensor.bench.processes import child_of, processor_s
from vsensor.bench.wakes import Wakes, bare_loop, of_ticks
from vsensor.config import Rig, effective_toml
from vsensor.errors import VsensorError
from vsensor.messages import SENSOR_STATUS, SENSOR_TICK, Status, Tick
from vsensor.recording.reader import Session
from vsensor.recording.summary import Summary

START_S = 1.0
"""The first second of ticks, and up to the next status, is left out of the lateness: what all three do once
is done by then."""
ARRIVE_S = 0.5
"""The last samples of a rig that has ended are on this machine's loopback; they need no longer."""
PUBLISHED = re.compile(r"^(\d+) samples a channel published$", re.MULTILINE)


class Processor(NamedTuple):
    """Processor time of the daemon and its recorder, and time on the wall, s."""

    daemon: float
    recorder: float
    wall: float


class Run(NamedTuple):
    """What a run left behind."""

    rate_hz: float
    published: int
    """Samples that the rig says it sent, both channels together."""
    summary: Summary
    status: Status
    """The daemon's last."""
    daemon: Wakes
    beside: Wakes | None
    """A bare loop in C in the same seconds; None without a compiler."""
    processor: Processor
    """What was taken while the rig published."""


def run(rig: Rig, folder: Path, seconds: float, bare: Path | None) -> Run:
    """Run everything for `seconds` and one to start in; `bare` is the compiled loop to run beside it.

    Raises VsensorError where a process fails.
    """
    rate = rig.loop.rate
    recording = rig.recording.model_copy(update={"enabled": True, "folder": folder})
    rig = demo.on_free_port(rig.model_copy(update={"recording": recording}))
    config = folder / "rig.toml"
    config.write_text(effective_toml(rig), encoding="utf-8")
    with demo.process("run", str(config)) as daemon:
        demo.await_ready(daemon)
        pids = (daemon.pid, child_of(daemon.pid))
        with (
            demo.process("simulate", str(config), "--duration", repr(START_S + seconds)) as source,
            bare_loop(bare, rate, seconds) if bare else nullcontext(lambda: None) as beside,
        ):
            before = _processor(*pids)
            published = _published(source)
            after = _processor(*pids)
            wakes = beside()
        time.sleep(ARRIVE_S)
        if daemon.poll() is not None:
            raise VsensorError(f"vsensor run ended with status {daemon.returncode}")
    taken = Processor(*(b - a for a, b in zip(before, after, strict=True)))
    return _recorded(rate, published, folder, wakes, taken)


def _published(source: subprocess.Popen[str]) -> int:
    """Wait for the rig's end, and read how many samples it has sent."""
    said, _ = source.communicate()
    found = PUBLISHED.search(said)
    if source.returncode or not found:
        raise VsensorError(f"vsensor simulate ended with status {source.returncode}: {said.strip()}")
    return 2 * int(found[1])


def _processor(daemon: int, recorder: int) -> Processor:
    return Processor(processor_s(daemon), processor_s(recorder), time.monotonic())


def _recorded(rate: float, published: int, folder: Path, beside: Wakes | None, taken: Processor) -> Run:
    (file,) = folder.glob("*.mcap")
    session = Session(file)
    statuses: list[Status] = []
    ticks: list[Tick] = []
    for record in session.messages((SENSOR_STATUS, SENSOR_TICK)):
        if isinstance(record.message, Status):
            statuses.append(record.message)
        elif isinstance(record.message, Tick):
            ticks.append(record.message)
    begun = [status for status in statuses if ticks and status.time_ns >= ticks[0].time_ns + START_S * 1e9]
    if not begun:
        raise VsensorError(f"{rate:g} Hz: {len(ticks)} ticks and {len(statuses)} statuses were recorded")
    first, last = begun[0], begun[-1]
    daemon = of_ticks(
        (tick for tick in ticks if tick.time_ns >= first.time_ns),
        last.slots_due - first.slots_due,
        last.slots_skipped - first.slots_skipped,
    )
    return Run(rate, published, session.summary(), last, daemon, beside, taken)
