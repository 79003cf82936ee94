"""What an event's `begins` says: something begins or ends, or was refused."""

from vsensor.messages.vsensor_pb2 import Event

REFUSABLE = ("configuration", "learned", "snapshot")
"""Events of what is asked for and done at once: they do not begin where it was refused."""


def is_refusal(event: Event) -> bool:
    """Whether it tells that something was refused."""
    return event.name in REFUSABLE and not event.begins


def verb(event: Event) -> str:
    """What has come of it, in a word."""
    if is_refusal(event):
        return "refused"
    return "begins" if event.begins else "ends"
