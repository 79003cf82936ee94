"""The keys below a rig's prefix, and the message that each carries."""

from vsensor.messages.vsensor_pb2 import Estimate, Event, Sample, Status, Tick

Message = Sample | Tick | Estimate | Status | Event

SURFACE = "surface/*"
SURFACE_TORQUE = "surface/torque"
SURFACE_SPEED = "surface/speed"
BIT_TORQUE = "bit/torque"
BIT_SPEED = "bit/speed"
BIT_ESTIMATE = "bit/estimate"
SENSOR_TICK = "sensor/tick"
SENSOR_STATUS = "sensor/status"
SENSOR_EVENT = "sensor/event"
SENSOR_ALIVE = "sensor/alive"  # a liveliness token, no message

_TYPES: dict[str, type[Message]] = {
    SURFACE_TORQUE: Sample,
    SURFACE_SPEED: Sample,
    BIT_TORQUE: Sample,
    BIT_SPEED: Sample,
    BIT_ESTIMATE: Estimate,
    SENSOR_TICK: Tick,
    SENSOR_STATUS: Status,
    SENSOR_EVENT: Event,
}


def message_type(topic: str) -> type[Message] | None:
    """The message that a topic (the key without the rig's prefix) carries; None where we know none."""
    return _TYPES.get(topic)
