"""Zenoh: sessions, and typed traffic over them."""

from vsensor.bus.feed import Feed
from vsensor.bus.inbox import SurfaceInbox
from vsensor.bus.outbox import SURFACE_CACHE, Outbox
from vsensor.bus.questions import Questions, ask_status, command
from vsensor.bus.queue import Received, recovering
from vsensor.bus.session import open_session, wait_for_sensor

__all__ = [
    "SURFACE_CACHE",
    "Feed",
    "Outbox",
    "Questions",
    "Received",
    "SurfaceInbox",
    "ask_status",
    "command",
    "open_session",
    "recovering",
    "wait_for_sensor",
]
