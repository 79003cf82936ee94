"""One life of a daemon, from its first second to its end, with all that a bus can throw at it."""

import math
import signal
import time
from dataclasses import dataclass, field
from pathlib import Path

from google.protobuf.json_format import MessageToJson

from tests.daemons import Post, daemon, free_bus, post, wait_until
from tests.rigs import NS, RATE, SHORT, samples, simulated
from vsensor.bus import wait_for_sensor
from vsensor.messages import (
    BIT_ESTIMATE,
    BIT_SPEED,
    BIT_TORQUE,
    SENSOR_STATUS,
    STRING_PROFILE,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Message,
    Sample,
    Status,
    surface,
)
from vsensor.messages.vsensor_pb2 import BAD
from vsensor.recording.reader import Session

HEARD = (BIT_SPEED, BIT_TORQUE, BIT_ESTIMATE, STRING_PROFILE)
UNREADABLE = (
    (b"", surface.PROTOBUF),
    (b"\xff\xff\xff", surface.PROTOBUF),
    (bytes(5_000_000), surface.PROTOBUF),
    (b"heavy", surface.TEXT),
    (b'{"value": "heavy"}', surface.JSON),
    (b"1.0", "image/png"),
)
REFUSED = {
    "unreadable": len(UNREADABLE),
    "not_finite": 3,
    "out_of_range": 1,
    "doubled": 1,
    "late": 1,
    "jumped": 1,
    "bad_at_source": 1,
    "over_rate": 0,
    "strays": 0,
}


@dataclass
class Life:
    """What was seen of a daemon while it lived, and what it left."""

    statuses: dict[str, Status] = field(default_factory=dict)
    """At moments that have names."""
    estimates_while_waiting: int = -1
    alive: bool = False
    replies: list[Status] = field(default_factory=list)
    heard: dict[str, list[Message]] = field(default_factory=dict)
    events: list[tuple[str, bool]] = field(default_factory=list)
    exit_status: int = -1
    said: str = ""
    session: Path = Path()

    def recorded(self, topic: str) -> list[Message]:
        """What the session holds of a topic."""
        return [record.message for record in Session(self.session).messages((topic,))]


def ask(rig: Post) -> list[Status]:
    replies = rig.session.get(f"{rig.prefix}/{SENSOR_STATUS}", timeout=20.0)
    return [Status.FromString(reply.ok.payload.to_bytes()) for reply in replies if reply.ok is not None]


def put(rig: Post, topic: str, payload: str | bytes, encoding: str) -> None:
    rig.session.put(f"{rig.prefix}/{topic}", payload, encoding=encoding)


def say_plainly(rig: Post) -> None:
    """Bare numbers, which bear the time at which they are sent, until some ticks have come of them."""

    def some_ticks() -> bool:
        put(rig, SURFACE_TORQUE, "100", surface.TEXT)
        put(rig, SURFACE_SPEED, "0.0", surface.TEXT)
        return len(rig.estimates) >= 5

    wait_until(some_ticks, "ticks of bare numbers")


def torment(rig: Post, last: Sample) -> None:
    """Send on the torque channel whatever a sample should not be."""
    for payload, encoding in UNREADABLE:
        put(rig, SURFACE_TORQUE, payload, encoding)
    put(rig, "surface/humidity", b"\xff", surface.PROTOBUF)
    put(rig, f"{SURFACE_TORQUE}/deeper", "1", surface.TEXT)
    soon = last.time_ns + NS // 1000
    for value in (math.nan, math.inf, -math.inf, 1e9):
        rig.send([(SURFACE_TORQUE, Sample(time_ns=soon, value=value))])
    for time_ns in (last.time_ns, last.time_ns - NS, last.time_ns + 3600 * NS):
        rig.send([(SURFACE_TORQUE, Sample(time_ns=time_ns, value=1.0))])
    rig.send([(SURFACE_TORQUE, Sample(time_ns=soon, value=1.0, quality=BAD))])


def torque(status: Status) -> dict[str, int]:
    """The books of the torque channel."""
    (channel,) = (c for c in status.channels if c.channel == SURFACE_TORQUE)
    return {name: getattr(channel, name) for name in ("received", "accepted", "lost", *REFUSED)}


def live(folder: Path) -> Life:
    """Run a daemon from its start to Ctrl-C, and note what is to be seen."""
    seen = Life()
    at = seen.statuses
    with daemon(SHORT, free_bus(), folder) as sensor:
        with post(sensor) as rig:
            at["waiting"] = rig.await_status(lambda status: status.state != "starting", "a first status")
            seen.estimates_while_waiting = len(rig.estimates)
            seen.alive = wait_for_sensor(rig.session, rig.prefix)
            seen.replies = ask(rig)

            say_plainly(rig)
            second = 2 * RATE
            good = samples(simulated(10), time.time_ns())
            rig.send(good[: 4 * second])
            for topic, sample in good[4 * second : 8 * second]:
                put(rig, topic, MessageToJson(sample, preserving_proto_field_name=True), surface.JSON)
            torment(rig, good[8 * second - 2][1])
            at["tormented"] = rig.await_status(
                lambda status: torque(status)["bad_at_source"] == 1, "the last of the bad samples"
            )
            rig.send(good[8 * second : 9 * second])
            at["after"] = rig.await_status(lambda s: s.ticks >= at["tormented"].ticks + RATE, "ticks again")
            at["lost"] = rig.await_status(lambda status: status.state == "input lost", "the loss of input")
            rig.send(good[9 * second :])
            at["back"] = rig.await_status(lambda status: status.state == "running", "the input's return")
            wait_until(lambda: ("input_lost", False) in rig.events, "the event of its return")
            seen.events = rig.events
            seen.heard = {topic: list(rig.heard(topic)) for topic in HEARD}
        seen.exit_status = sensor.end(signal.SIGINT)
        seen.said = sensor.said
        (seen.session,) = sensor.sessions
    return seen
