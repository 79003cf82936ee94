"""What the live view costs: its processes, how late it shows an estimate, and what it does to the loop.

The daemon runs without and with the view in turn, several times, so that the machine's own doing shows.
"""

import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, nullcontext
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vsensor import demo
from vsensor.bench.live import rig_at
from vsensor.bench.processes import processor_s, resident_bytes
from vsensor.bench.seen import Integers, delays_ns
from vsensor.bench.served import PATIENCE_S, View, served
from vsensor.bench.table import Cell, Table
from vsensor.bench.wakes import Wakes, of_ticks
from vsensor.bus import Feed, ask_status, open_session
from vsensor.config import Rig, effective_toml
from vsensor.errors import VsensorError
from vsensor.messages import BIT_ESTIMATE, SENSOR_TICK, Estimate, Tick

PAIRS = 5
WARM_S = 4.0
"""Before each part: what begins or ends has its own cost."""
ASKED = 1.05
"""What the view may do to the loop's lateness."""
_LOOK_S = 0.001


class Part(NamedTuple):
    """What was measured in one part, without or with the view."""

    wakes: Wakes
    processor: tuple[float, float]
    """Shares of one core that the view's process and its page's server took; 0 without the view."""
    resident: int
    """Bytes that both held at the end."""
    delays_ns: Integers


class Pairs(NamedTuple):
    """All parts at one rate."""

    rate_hz: float
    scheduling: str
    without: list[Part]
    seen: list[Part]


def tables(rates_hz: Sequence[float], seconds: float, say: Callable[[str], None]) -> Iterator[Table]:
    """Run the demonstration's rig and daemon at each rate, with real-time priority if granted.

    Raises VsensorError where a process fails.
    """
    measured = []
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as name:
        for rig in [rig_at(rate) for rate in rates_hz]:
            folder = Path(tempfile.mkdtemp(dir=name))
            measured.append(_pairs(_alone(rig, folder), folder, seconds, say))
    yield _cost(measured)
    yield _lateness(measured)


def _alone(rig: Rig, folder: Path) -> Rig:
    loop = rig.loop.model_copy(update={"realtime": "prefer"})
    recording = rig.recording.model_copy(update={"enabled": False, "folder": folder})
    return demo.on_free_port(rig.model_copy(update={"loop": loop, "recording": recording}))


def _pairs(rig: Rig, folder: Path, seconds: float, say: Callable[[str], None]) -> Pairs:
    config = folder / "rig.toml"
    config.write_text(effective_toml(rig), encoding="utf-8")
    rate = rig.loop.rate
    say(f"rig and daemon start at {rate:g} Hz")
    with ExitStack() as running:
        demo.await_ready(running.enter_context(demo.process("run", str(config))))
        running.enter_context(demo.process("simulate", str(config)))
        session = running.enter_context(open_session(rig.bus, "client"))
        feed = Feed(session, rig.prefix, (SENSOR_TICK, BIT_ESTIMATE))
        _await_ticks(feed)
        found = Pairs(rate, ask_status(session, rig.prefix).scheduling, [], [])
        for number in range(PAIRS):
            for with_view in (False, True) if number % 2 == 0 else (True, False):
                say(f"{rate:g} Hz {'with' if with_view else 'without'} the view, {number + 1} of {PAIRS}")
                view = served(config, folder / f"{number}.rrd") if with_view else nullcontext()
                with view as at_work:
                    _listen(feed, at_work, WARM_S)
                    part = _part(feed, at_work, seconds)
                (found.seen if with_view else found.without).append(part)
    return found


def _await_ticks(feed: Feed) -> None:
    """The rig takes its time to start."""
    end = time.monotonic() + PATIENCE_S
    while not any(isinstance(message, Tick) for _, message in feed.drain()):
        if time.monotonic() > end:
            raise VsensorError(f"the simulated rig sends nothing: no tick for {PATIENCE_S:g} s")
        time.sleep(_LOOK_S)


def _part(feed: Feed, view: View | None, seconds: float) -> Part:
    pids = view.pids if view else ()
    before, begun = [processor_s(pid) for pid in pids], time.monotonic()
    ticks, published = _listen(feed, view, seconds)
    lasted = time.monotonic() - begun
    took = [(processor_s(pid) - was) / lasted for pid, was in zip(pids, before, strict=True)]
    return Part(
        of_ticks(ticks, 0, 0),
        (took[0], took[1]) if view else (0.0, 0.0),
        sum(map(resident_bytes, pids)),
        delays_ns(published, view.looks) if view else np.empty(0, np.int64),
    )


def _listen(feed: Feed, view: View | None, seconds: float) -> tuple[list[Tick], list[tuple[int, int]]]:
    """What the daemon publishes in so many seconds: its ticks, and when which estimate was there."""
    ticks: list[Tick] = []
    published: list[tuple[int, int]] = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for _, message in feed.drain():
            if isinstance(message, Tick):
                ticks.append(message)
            elif isinstance(message, Estimate) and message.HasField("now_bit_speed_rad_s"):
                published.append((time.monotonic_ns(), message.time_ns))
        if view:
            view.looks.look()
        time.sleep(_LOOK_S)
    return ticks, published


def _cost(measured: Sequence[Pairs]) -> Table:
    return Table(
        "View: what it takes, and how late a viewer has an estimate",
        (
            *("loop", "view, % of one core", "page's server, %", "memory, MB"),
            *("median, ms", "99 %, ms", "worst, ms"),
        ),
        tuple(_cost_row(one) for one in measured),
        (
            "from an estimate heard on the bus, in another process, to its point of the speed's line in a "
            "client of the view's server, which is Rerun's own; drawing comes on top. The view sends all "
            "that has come ten times a second: 50 ms of the median are the wait for that.",
        ),
    )


def _cost_row(one: Pairs) -> tuple[Cell, ...]:
    delays = np.concatenate([part.delays_ns for part in one.seen]) / 1e6
    told: list[Cell] = (
        [float(np.percentile(delays, share)) for share in (50, 99, 100)] if len(delays) else [None] * 3
    )
    return (
        f"{one.rate_hz:g} Hz",
        *(
            100 * float(np.mean(shares))
            for shares in zip(*(part.processor for part in one.seen), strict=True)
        ),
        max(part.resident for part in one.seen) / 1e6,
        *told,
    )


def _lateness(measured: Sequence[Pairs]) -> Table:
    return Table(
        "View: how late the loop wakes without and with it, 99 % below",
        ("loop", "without, µs", "with, µs", "ratio", "asked"),
        tuple(row for one in measured for row in _lateness_rows(one)),
        tuple(
            f"{one.rate_hz:g} Hz: {one.scheduling}; median without {_all(one.without, 50):.1f} µs, "
            f"with {_all(one.seen, 50):.1f} µs"
            for one in measured
        ),
    )


def _lateness_rows(one: Pairs) -> Iterator[tuple[Cell, ...]]:
    for number, (without, seen) in enumerate(zip(one.without, one.seen, strict=True), 1):
        either = without.wakes.percentile_us(99), seen.wakes.percentile_us(99)
        yield f"{one.rate_hz:g} Hz, {number}", *either, either[1] / either[0], None
    either = _all(one.without, 99), _all(one.seen, 99)
    yield f"{one.rate_hz:g} Hz, all", *either, either[1] / either[0], ASKED


def _all(parts: Sequence[Part], share: float) -> float:
    every = np.concatenate([part.wakes.lateness_ns for part in parts])
    return float(np.percentile(every, share)) / 1e3
