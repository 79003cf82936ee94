"""A rig that times the sensor: `python -m vsensor.bench.probe CONFIG ECHO`; each line of input is a report.

It sends both channels at the loop's rate, and hears the estimates that come of them; between them it asks a
bare Zenoh echo. From the tick of each estimate, and the loop's grid, it knows how long the input had to wait.
"""

import json
import sys
import threading
import time
from pathlib import Path

import numpy as np
import zenoh

from vsensor.bench.echo import ANSWERED, ASKED
from vsensor.bench.record import endless
from vsensor.bus import Outbox, open_session
from vsensor.config import Bus, Rig, load
from vsensor.grid import NS
from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_STATUS,
    SENSOR_TICK,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Estimate,
    Sample,
    Status,
    Tick,
)
from vsensor.service.pace import MonotonicClock, Pace

ECHOES_HZ = 100.0
ASKED_AFTER = (0.25, 0.75)
"""Shares of a slot after the samples, by chance: right behind them it would find all processors awake, as no
estimate does."""
SWEEP_S = 5.0
"""The samples come by a slot later in so much time, so that all phases of the slot have their turn."""
LOOKED_AT = 50_000
"""So many answers are kept for a report."""


class Probe:
    """What was sent and heard since the last report."""

    def __init__(self, rig: Rig, session: zenoh.Session, echo: zenoh.Session) -> None:
        self._rig = rig
        self._outbox = Outbox(session, rig.prefix, reliable=True)
        self._asks = echo.declare_publisher(ASKED, express=True)
        self._lock = threading.Lock()
        self._grid_ns = 0
        self._begin()
        self._subscribers = [
            session.declare_subscriber(f"{rig.prefix}/{BIT_ESTIMATE}", self._hear),
            session.declare_subscriber(f"{rig.prefix}/{SENSOR_TICK}", self._hear_tick),
            session.declare_subscriber(f"{rig.prefix}/{SENSOR_STATUS}", self._hear_status),
            echo.declare_subscriber(ANSWERED, self._hear_echo),
        ]
        self._sent = 0

    def _begin(self) -> None:
        self._put_ns: dict[int, int] = {}
        self._heard: list[tuple[int, bytes]] = []
        self._ticks: list[bytes] = []
        self._echoed: list[tuple[int, int]] = []

    def run(self, torque: list[float], speed: list[float]) -> None:
        """Send for ever, the record again and again."""
        begun_ns = time.time_ns()
        every = max(1, round(self._rig.loop.rate / ECHOES_HZ))
        clock, chance = MonotonicClock(), np.random.default_rng(1)
        rate = self._rig.loop.rate - 1 / SWEEP_S
        pace = Pace(rate, clock)
        for slot in pace.slots():
            for number in range(slot.number - slot.skipped, slot.number + 1):
                self._send(number, begun_ns, torque[number % len(torque)], speed[number % len(speed)])
            if slot.number % every == 0:
                after = (slot.number + chance.uniform(*ASKED_AFTER)) / rate
                clock.sleep_until(pace.start_ns + round(after * NS))
                self._asks.put(time.monotonic_ns().to_bytes(8, "little").ljust(40, b"\0"))

    def _send(self, number: int, begun_ns: int, torque: float, speed: float) -> None:
        time_ns = begun_ns + round(number * NS / self._rig.loop.rate)
        self._outbox.put(SURFACE_TORQUE, Sample(time_ns=time_ns, value=torque, sequence=self._sent))
        self._put_ns[time_ns] = time.monotonic_ns()
        self._outbox.put(SURFACE_SPEED, Sample(time_ns=time_ns, value=speed, sequence=self._sent))
        self._sent += 1

    def _hear(self, raw: zenoh.Sample) -> None:
        if len(self._heard) < LOOKED_AT:
            self._heard.append((time.monotonic_ns(), raw.payload.to_bytes()))

    def _hear_tick(self, raw: zenoh.Sample) -> None:
        if len(self._ticks) < LOOKED_AT:
            self._ticks.append(raw.payload.to_bytes())

    def _hear_status(self, raw: zenoh.Sample) -> None:
        self._grid_ns = Status.FromString(raw.payload.to_bytes()).grid_ns

    def _hear_echo(self, raw: zenoh.Sample) -> None:
        now = time.monotonic_ns()
        self._echoed.append((now, int.from_bytes(raw.payload.to_bytes()[:8], "little")))

    def report(self) -> dict[str, list[float]]:
        """Latencies since the last report, ns: whole, behind the wait for the tick, and the echo's."""
        put_ns, heard, ticks, echoed = self._put_ns, self._heard, self._ticks, self._echoed
        self._begin()
        woken = {tick.time_ns: self._woken_ns(tick) for tick in map(Tick.FromString, ticks)}
        whole: list[float] = []
        behind: list[float] = []
        for at_ns, data in heard:
            time_ns = Estimate.FromString(data).time_ns
            if time_ns in put_ns and time_ns in woken:
                whole.append(at_ns - put_ns[time_ns])
                behind.append(at_ns - woken[time_ns])
        return {"whole": whole, "behind": behind, "echo": [at - asked for at, asked in echoed]}

    def _woken_ns(self, tick: Tick) -> int:
        return self._grid_ns + round(tick.slot * NS / self._rig.loop.rate) + tick.lateness_ns


def main(config: Path, echo: str) -> None:
    """Send until standard input ends; for each line of it write a report as JSON."""
    rig = load(config)
    torque, speed = (values.tolist() for values in endless(rig))
    with open_session(rig.bus, "client") as session, open_session(Bus(listen=(echo,)), "client") as other:
        probe = Probe(rig, session, other)
        threading.Thread(target=probe.run, args=(torque, speed), daemon=True).start()
        for _line in sys.stdin:
            sys.stdout.write(json.dumps(probe.report()) + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
