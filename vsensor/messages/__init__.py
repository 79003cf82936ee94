"""What goes over the bus and into sessions: the schema, its generated code, the keys."""

from vsensor.messages.topics import (
    BIT_ESTIMATE,
    BIT_SPEED,
    BIT_TORQUE,
    SENSOR_ALIVE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    SENSOR_TICK,
    STRING_PROFILE,
    SURFACE,
    SURFACE_SPEED,
    SURFACE_TOPICS,
    SURFACE_TORQUE,
    Message,
    message_type,
)
from vsensor.messages.vsensor_pb2 import ChannelStatus, Estimate, Event, Profile, Sample, Status, Tick

__all__ = [
    "BIT_ESTIMATE",
    "BIT_SPEED",
    "BIT_TORQUE",
    "SENSOR_ALIVE",
    "SENSOR_EVENT",
    "SENSOR_STATUS",
    "SENSOR_TICK",
    "STRING_PROFILE",
    "SURFACE",
    "SURFACE_SPEED",
    "SURFACE_TOPICS",
    "SURFACE_TORQUE",
    "ChannelStatus",
    "Estimate",
    "Event",
    "Message",
    "Profile",
    "Sample",
    "Status",
    "Tick",
    "message_type",
]
