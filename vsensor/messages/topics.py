"""The keys below a rig's prefix, and the message that each carries."""

from vsensor.messages.vsensor_pb2 import (
    Description,
    Estimate,
    Event,
    Profile,
    Sample,
    State,
    Status,
    Tick,
    Unreadable,
)

Message = Sample | Tick | Estimate | Profile | Description | Status | Event | State | Unreadable

SURFACE = "surface/*"
SURFACE_TORQUE = "surface/torque"
SURFACE_SPEED = "surface/speed"
SURFACE_BIT_DEPTH = "surface/bit_depth"  # optional, m
SURFACE_HOLE_DEPTH = "surface/hole_depth"  # optional, m
BIT_TORQUE = "bit/torque"
BIT_SPEED = "bit/speed"
BIT_ESTIMATE = "bit/estimate"
STRING_PROFILE = "string/profile"
STRING_DESCRIPTION = "string/description"
SENSOR_TICK = "sensor/tick"
SENSOR_STATUS = "sensor/status"
SENSOR_EVENT = "sensor/event"
SENSOR_STATE = "sensor/state"
SENSOR_UNREADABLE = "sensor/unreadable"
IN_SESSIONS_ALONE = (SENSOR_STATE, SENSOR_UNREADABLE)
DEPTH_TOPICS = (SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH)
SURFACE_TOPICS = (SURFACE_TORQUE, SURFACE_SPEED, *DEPTH_TOPICS)
SENSOR_COMMAND = "sensor/command"  # queryable
SENSOR_ALIVE = "sensor/alive"  # a liveliness token, no message

_TYPES: dict[str, type[Message]] = {
    SURFACE_TORQUE: Sample,
    SURFACE_SPEED: Sample,
    SURFACE_BIT_DEPTH: Sample,
    SURFACE_HOLE_DEPTH: Sample,
    BIT_TORQUE: Sample,
    BIT_SPEED: Sample,
    BIT_ESTIMATE: Estimate,
    STRING_PROFILE: Profile,
    STRING_DESCRIPTION: Description,
    SENSOR_TICK: Tick,
    SENSOR_STATUS: Status,
    SENSOR_EVENT: Event,
    SENSOR_STATE: State,
    SENSOR_UNREADABLE: Unreadable,
}


def message_type(topic: str) -> type[Message] | None:
    """The message that a topic (the key without the rig's prefix) carries; None where we know none."""
    return _TYPES.get(topic)
