"""What a sensor counted in a session: a status counts since the sensor began, which may be long before."""

from vsensor.grid import NS
from vsensor.messages import Status
from vsensor.messages.books import LOSSES

BEGAN_WITH_IT_S = 2.0
"""A sensor that had run for no longer when its session began counted nothing before it."""
_OF_STATUS = ("slots_due", "slots_skipped", "restarts", "ticks")
_OF_STICKS = ("sticks_foretold", "sticks_missed", "sticks_false")
_OF_CHANNEL = ("received", "accepted", *LOSSES)


def counted(first: Status, last: Status, begun_ns: int) -> Status:
    """The last status, its counts less those of the first, of a session that was begun at `begun_ns`.

    So what a part of a longer recording tells is its own, but for the second before its first status.
    """
    told = Status()
    told.CopyFrom(last)
    if first.uptime_s - (first.time_ns - begun_ns) / NS <= BEGAN_WITH_IT_S:
        return told
    for name in (*_OF_STATUS, *_OF_STICKS):
        if getattr(last, name):  # what was never counted stays unsaid
            setattr(told, name, max(0, getattr(last, name) - getattr(first, name)))
    before = {channel.channel: channel for channel in first.channels}
    for channel in told.channels:
        for name in _OF_CHANNEL if channel.channel in before else ():
            setattr(channel, name, max(0, getattr(channel, name) - getattr(before[channel.channel], name)))
    _warned(told, first, last)
    return told


def _warned(told: Status, first: Status, last: Status) -> None:
    """How long ahead sticks were foretold on average: of those that came meanwhile."""
    told.ClearField("stick_lead_s")
    if told.sticks_foretold:
        total = last.stick_lead_s * last.sticks_foretold - first.stick_lead_s * first.sticks_foretold
        told.stick_lead_s = total / told.sticks_foretold
