"""What goes into a session besides what is published."""

from typing import cast

import zenoh

from tests.rigs import SHORT
from vsensor.bus import Received
from vsensor.messages import SENSOR_UNREADABLE, SURFACE_SPEED, SURFACE_TORQUE, Sample, Unreadable
from vsensor.service.health import Health
from vsensor.service.recording import Recorder
from vsensor.service.voice import UNREADABLE_HZ, Voice


class Offered:
    """What a recorder is offered."""

    def __init__(self) -> None:
        self.topics: list[str] = []

    def offer(self, topic: str, _data: bytes, _log_time_ns: int, _publish_time_ns: int) -> None:
        self.topics.append(topic)


def test_a_flood_of_what_cannot_be_read_takes_no_room_from_what_can() -> None:
    recorder = Offered()
    voice = Voice(
        cast("zenoh.Session", None), SHORT, cast("Recorder", recorder), cast("Health", None)
    )  # nothing is sent
    junk = Unreadable(time_ns=1, channel=SURFACE_TORQUE, encoding="image/png", fault="is a picture")
    for number in range(500):
        voice.record_received(Received(SURFACE_TORQUE, number, None, junk))
        voice.record_received(Received(SURFACE_SPEED, number, Sample(time_ns=number, value=1.0)))
    assert recorder.topics.count(SURFACE_SPEED) == 500
    assert UNREADABLE_HZ <= recorder.topics.count(SENSOR_UNREADABLE) < 3 * UNREADABLE_HZ
