"""What goes out of the daemon: to the bus, and as it went there into the session."""

import time

import zenoh

from vsensor.bus import Outbox, Received
from vsensor.bus.allowance import Allowance
from vsensor.config import Rig
from vsensor.messages import (
    BIT_ESTIMATE,
    BIT_SPEED,
    BIT_TORQUE,
    SENSOR_EVENT,
    SENSOR_UNREADABLE,
    Estimate,
    Event,
    Message,
    Sample,
)
from vsensor.service.health import Health
from vsensor.service.recording import Recorder

Sent = tuple[str, bytes]
"""A topic, and the bytes of a message that was sent."""
_SENSORS = (
    (BIT_SPEED, ("now_bit_speed_rad_s", "now_bit_speed_std_rad_s")),
    (BIT_TORQUE, ("now_bit_torque_nm", "now_bit_torque_std_nm")),
)
"""What is told as a real sensor would tell it: the fields of value and deviation."""
UNREADABLE_HZ = 20
"""So many unreadable samples a second are kept as they came: the rest is only counted, for a flood of them is
many times as much as all else that is recorded."""


class Voice:
    """Publishes, records, and keeps count of how long that takes."""

    def __init__(self, session: zenoh.Session, rig: Rig, recorder: Recorder | None, health: Health) -> None:
        self._outbox = Outbox(session, rig.prefix, reliable=False)
        self._recorder = recorder
        self._health = health
        self._news: list[Event] = []
        self._unreadable = Allowance(UNREADABLE_HZ, UNREADABLE_HZ)

    def mute(self, muted: bool) -> None:
        """Whether another speaks: then nothing goes to the bus."""
        self._outbox.muted = muted

    def publish(self, topic: str, message: Message, publish_time_ns: int) -> None:
        """Send a message and record it."""
        self.record(topic, self.send(topic, message), publish_time_ns)

    def send(self, topic: str, message: Message) -> bytes:
        """Send a message; returns its bytes, to be recorded."""
        begun = time.monotonic_ns()
        data = self._outbox.put(topic, message)
        self._health.publishes(time.monotonic_ns() - begun)
        return data

    def answer(self, estimate: Estimate) -> list[Sent]:
        """Send what is known of the bit: the estimate and, where there is a now, that of two sensors."""
        told = [(BIT_ESTIMATE, self.send(BIT_ESTIMATE, estimate))]
        if estimate.HasField("now_bit_speed_rad_s"):
            told += ((topic, self.send(topic, _as_sensor(estimate, *of))) for topic, of in _SENSORS)
        return told

    def record(self, topic: str, data: bytes, publish_time_ns: int) -> None:
        """Record what was sent."""
        if self._recorder is not None:
            self._recorder.offer(topic, data, time.time_ns(), publish_time_ns)

    def record_received(self, received: Received) -> None:
        """Record a sample as it came, apart from the others where it could not be read."""
        if self._recorder is None:
            return
        if (sample := received.sample) is not None:
            data = sample.SerializeToString()
            self._recorder.offer(received.topic, data, received.received_ns, sample.time_ns)
        elif (kept := received.unreadable) is not None and self._unreadable.take(time.monotonic_ns()):
            self._recorder.offer(
                SENSOR_UNREADABLE, kept.SerializeToString(), received.received_ns, kept.time_ns
            )

    def hand_on(self) -> None:
        """Hand over to the recorder what this slot had for it."""
        if self._recorder is not None:
            self._recorder.send()

    def tell(self, event: Event) -> None:
        """Publish an event, and keep it for the log."""
        self._news.append(event)
        self.publish(SENSOR_EVENT, event, event.time_ns)

    def news(self) -> list[Event]:
        """The events since the last call."""
        news, self._news = self._news, []
        return news


def _as_sensor(estimate: Estimate, value: str, deviation: str) -> Sample:
    """A now estimate in the form in which a real sensor would send it."""
    return Sample(
        time_ns=estimate.time_ns,
        value=getattr(estimate, value),
        sequence=estimate.number,
        standard_deviation=getattr(estimate, deviation),
        quality=estimate.quality,
        reasons=estimate.reasons,
    )
