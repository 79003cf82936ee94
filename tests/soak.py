"""A daemon under random faults for as long as asked, and its books: `python -m tests.soak --minutes 30`.

Each sample that was published is consumed, refused for a reason, or lost and counted; and the session that
is left verifies to the bit, whatever happened. The same seed makes the same faults, if not at the same tick.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import zenoh

from tests.daemons import Daemon, daemon, free_bus, wait_until
from tests.link import Link, link
from tests.rigs import NS, SHORT
from tests.troubled import CHANNELS, Books, TroubledRig
from vsensor.bus import SURFACE_CACHE, Outbox, open_session
from vsensor.config import Rig
from vsensor.messages import SENSOR_STATUS, SENSOR_TICK, SURFACE_SPEED, Status, Tick
from vsensor.messages.books import REFUSALS
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine

VIEWER = """
import sys, zenoh
with zenoh.open(zenoh.Config.from_json5(sys.argv[1])) as session:
    for sample in session.declare_subscriber("**"):
        pass
"""


class Soak:
    """The faults around a daemon: links, processes, clocks."""

    def __init__(self, sensor: Daemon, wire: Link, viewer: subprocess.Popen[bytes], rig: TroubledRig) -> None:
        self._sensor = sensor
        self._wire = wire
        self._viewer = viewer
        self._rig = rig

    @property
    def all(self) -> dict[str, Callable[[float], Iterator[float]]]:
        """By name; each yields how long it lasts, and mends itself behind that."""
        return {
            "link cut": self._cut,
            "daemon stopped": lambda most: self._stop(self._sensor.process.pid, most),
            "recorder stopped": lambda most: self._stop(self._sensor.recorder, most),
            "viewer frozen": lambda most: self._stop(self._viewer.pid, most),
            "one channel silent": lambda most: self._silence({SURFACE_SPEED}, most),
            "both silent": lambda most: self._silence(set(CHANNELS), most),
            "publisher restarted": self._restart,
            "clock set": self._set_clock,
            "busy neighbour": self._burn,
        }

    def _cut(self, lasting: float) -> Iterator[float]:
        self._wire.cut()
        yield min(lasting, 5.0)
        self._wire.mend()

    def _stop(self, pid: int, lasting: float) -> Iterator[float]:
        os.kill(pid, signal.SIGSTOP)
        yield lasting
        os.kill(pid, signal.SIGCONT)

    def _silence(self, channels: set[str], lasting: float) -> Iterator[float]:
        self._rig.silent |= channels
        yield lasting
        self._rig.silent.clear()

    def _restart(self, _lasting: float) -> Iterator[float]:
        self._rig.begin_anew()
        yield 0.0

    def _set_clock(self, lasting: float) -> Iterator[float]:
        self._rig.shift_ns += round((20 + 60 * lasting) * NS)
        yield 0.0

    def _burn(self, lasting: float) -> Iterator[float]:
        with subprocess.Popen([sys.executable, "-c", "while True: pass"]) as neighbour:
            yield lasting
            neighbour.kill()


def soak(rig: Rig, seconds: float, seed: int, folder: Path, say: Callable[[str], None]) -> list[str]:
    """Run it; returns what does not balance, nothing if all does."""
    chance = random.Random(seed)
    with daemon(rig, free_bus(), folder) as sensor, link(sensor.rig.bus) as wire:
        config = f'{{mode: "client", connect: {{endpoints: ["{sensor.rig.bus.listen[0]}"]}}}}'
        viewer = subprocess.Popen([sys.executable, "-c", VIEWER, config])
        try:
            with (
                open_session(wire.bus, "client") as session,
                open_session(sensor.rig.bus, "client") as listener,
            ):
                heard = listener.declare_subscriber(
                    f"{rig.prefix}/{SENSOR_STATUS}", zenoh.handlers.RingChannel(1)
                )
                outbox = Outbox(session, rig.prefix, reliable=True, cache=SURFACE_CACHE)
                troubled = TroubledRig(outbox, rig.loop.rate, seed)
                _suffer(Soak(sensor, wire, viewer, troubled), troubled, chance, seconds, say)
                troubled.end()
                status = _settled(heard, troubled.books, sensor)
        finally:
            viewer.kill()
            viewer.wait()
        ended = sensor.end(signal.SIGTERM)
        return [*_imbalances(troubled.books, status, say), *_session_faults(sensor, status, ended, say)]


def _suffer(
    around: Soak, rig: TroubledRig, chance: random.Random, seconds: float, say: Callable[[str], None]
) -> None:
    """Faults one after the other, with some seconds of peace between them."""
    end = time.monotonic() + seconds
    _live(rig, min(4.0, seconds / 4))
    while (left := end - time.monotonic()) > 0:
        name, fault = chance.choice(list(around.all.items()))
        lasting = min(10 ** chance.uniform(-1, 1), left)
        say(f"{left:6.0f} s to go: {name}, {lasting:.1f} s")
        rig.books.faults[name] += 1
        for pause in fault(lasting):
            _live(rig, pause)
        _live(rig, min(chance.uniform(0.5, 8.0), seconds / 8))


def _live(rig: TroubledRig, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        rig.catch_up()
        time.sleep(0.001)


def _settled(
    heard: "zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]", books: Books, sensor: Daemon
) -> Status:
    """The status once all that was published has come or is known to be lost."""
    latest: list[Status] = []

    def quiet() -> bool:
        assert sensor.process.poll() is None, f"the daemon has ended: {sensor.said[-2000:]}"
        if (raw := heard.try_recv()) is not None:
            latest.append(Status.FromString(raw.payload.to_bytes()))
        came = sum(channel.received for channel in latest[-1].channels) if latest else 0
        return bool(latest) and came + latest[-1].bus_missed >= sum(books.published.values())

    wait_until(quiet, f"all of {dict(books.published)}")
    return latest[-1]


def _imbalances(books: Books, status: Status, say: Callable[[str], None]) -> Iterator[str]:
    say(f"faults: {dict(books.faults)}")
    say(f"shed {status.sheddings} times, {status.restarts} restarts, {status.slots_skipped} slots skipped")
    received = 0
    for channel in status.channels:
        refused = {reason: getattr(channel, reason) for reason in REFUSALS}
        received += channel.received
        say(
            f"{channel.channel}: published {books.published[channel.channel]}, received {channel.received} "
            f"= accepted {channel.accepted} + refused {sum(refused.values())} {refused}; "
            f"never sent {books.withheld[channel.channel]}, counted as lost {channel.lost}"
        )
        if channel.received != channel.accepted + sum(refused.values()):
            yield f"{channel.channel}: received is not accepted and refused"
        # A hole just before the publisher counts from 0 again cannot be seen.
        unseen = books.faults["publisher restarted"] + status.bus_missed
        if abs(channel.lost - books.withheld[channel.channel]) > unseen:
            yield f"{channel.channel}: what was never sent is not what was counted as lost"
    published = sum(books.published.values())
    say(f"published {published} = received {received} + lost by the bus {status.bus_missed}")
    if published != received + status.bus_missed:
        yield "published is not received and lost"


def _session_faults(sensor: Daemon, status: Status, ended: int, say: Callable[[str], None]) -> Iterator[str]:
    if ended:
        yield f"the daemon ended with status {ended}: {sensor.said[-2000:]}"
    recorded = 0
    for path in sensor.sessions:
        session = Session(path)
        verdict = verify(session, Engine(sensor.rig))
        say(f"{path.name}: {verdict.ticks} ticks, {verdict.compared} compared, {len(verdict.gaps)} gaps")
        if verdict.mismatches or verdict.misfit:
            yield f"{path.name}: {verdict.mismatches} estimates differ: {verdict.first} {verdict.misfit}"
        recorded += sum(isinstance(r.message, Tick) for r in session.messages((SENSOR_TICK,)))
    say(f"{recorded} ticks recorded of {status.ticks}, {status.recorder_dropped} messages not recorded")
    if recorded < status.ticks and not status.recorder_dropped:
        yield f"{status.ticks - recorded} ticks were not recorded, and nothing was counted"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--rate", type=float, default=1000.0, help="Hz, of ticks and samples")
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6))
    given = parser.parse_args()

    def say(words: str) -> None:
        sys.stdout.write(f"{words}\n")
        sys.stdout.flush()

    say(f"seed {given.seed}")
    rig = SHORT.model_copy(update={"loop": SHORT.loop.model_copy(update={"rate": given.rate})})
    with tempfile.TemporaryDirectory(prefix="vsensor-soak-") as folder:
        wrong = soak(rig, 60 * given.minutes, given.seed, Path(folder), say)
    say("\n".join(wrong) if wrong else "the books balance")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
