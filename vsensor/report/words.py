"""What happened, in words and key figures: what a person reads first."""

from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

from vsensor.messages.books import LOSSES
from vsensor.recording.summary import Summary
from vsensor.report.along import Along
from vsensor.report.figures import TURNING, Sticking
from vsensor.report.gather import Story
from vsensor.report.plots import KNM, RPM
from vsensor.report.seconds import Severity
from vsensor.report.ticks import BIT, BIT_TORQUE, TOP, TOP_TORQUE, Floats

_UNIX_NS = 10**17
_STICKS = 0.01
"""From this share of the time on it is stick-slip;"""
_SWINGS = 0.3
"""from this severity on the bit swings."""
_ALIKE = 0.1
"""Bit and top turn alike on average, but for such a share: over less than a swing they do not."""


class Key(NamedTuple):
    """A figure that is read first."""

    name: str
    value: str
    beside: str = ""
    grave: bool = False


def headline(story: Story, severity: Severity, sticks: Sticking) -> str:
    """One or two sentences that say what happened."""
    bit, mean = story.extents[BIT], story.extents[TOP].mean * RPM
    if np.isnan(bit.least):
        return "The sensor never got warm: nothing is known of the bit."
    ran = f"the bit ran between {_rpm(bit.least)} and {_rpm(bit.greatest)} rpm"
    turned = f"the top turned at {mean:.0f} rpm on average"
    fastest, worst = max(-bit.least, bit.greatest), _most(severity.value)
    if sticks.share >= _STICKS and fastest < TURNING:
        return f"The bit stood still in all that is known of it, {sticks.longest_s:.1f} s on end; {turned}."
    if sticks.share >= _STICKS:
        return (
            f"Stick-slip: the bit stood still {sticks.share:.0%} of the time, {_times(sticks.times)}, up to "
            f"{sticks.longest_s:.1f} s on end, and ran up to {_rpm(fastest)} rpm in between; {turned}."
        )
    if worst >= _SWINGS:
        return f"Torsional swings: {ran}; {turned}, severity was {worst:.2f} at its worst."
    if abs(mean) < 1:
        return "The string hardly turned."
    if abs(bit.mean - story.extents[TOP].mean) > _ALIKE * abs(story.extents[TOP].mean):
        return f"Bit and top did not turn alike: {ran}; {turned}."
    calm = (
        f"severity stayed below {worst + 0.01:.2f}" if np.isfinite(worst) else "too short to tell how rough"
    )
    return f"Smooth: the bit turned with the top, at {mean:.0f} rpm; {calm}."


def strained(worst: Along | None) -> str:
    """How near the string came to what it bears; empty where nothing is known of that."""
    if worst is None or not np.isfinite(worst.margin).any():
        return ""
    at = int(np.nanargmin(worst.margin))
    margin, depth = float(worst.margin[at]), float(worst.depth_m[at])
    loads = f"{worst.torque_nm[at] * KNM:.1f} of {worst.limit_nm[at] * KNM:.1f} kN·m"
    if margin < 0:
        return f"The string bore more than it may, {depth:.0f} m down: {loads}."
    return f"The string came nearest to its limit {depth:.0f} m down, at {loads}: {margin:.0%} were left."


def keys(story: Story, summary: Summary, severity: Severity, sticks: Sticking) -> list[Key]:
    """The figures that are read first."""
    bit, top, on_bit, torque = (story.extents[name] for name in (BIT, TOP, BIT_TORQUE, TOP_TORQUE))
    worst = _most(severity.value)
    margin = _least(story.along.margin) if story.along else np.nan
    return [
        Key("top speed", _told(top.mean * RPM, "rpm"), "mean"),
        Key(
            "bit speed",
            "–" if np.isnan(bit.least) else f"{_rpm(bit.least)} … {_rpm(bit.greatest)} rpm",
            "least and greatest",
        ),
        Key(
            "severity",
            _told(worst, "", 2),
            f"worst; half the time above {_told(_middle(severity.value), '', 2)}",
            worst >= 1,
        ),
        Key(
            "bit stuck",
            "–" if np.isnan(sticks.share) else f"{sticks.share:.0%}",
            f"of the time, {_times(sticks.times)}",
            sticks.share >= _STICKS,
        ),
        Key(
            "torque, top",
            _told(torque.mean * KNM, "kN·m", 1),
            f"mean; greatest {_told(torque.greatest * KNM, '', 1)}",
        ),
        Key(
            "torque, bit",
            _told(on_bit.mean * KNM, "kN·m", 1),
            f"mean; greatest {_told(on_bit.greatest * KNM, '', 1)}",
        ),
        Key(
            "margin",
            f"{margin:.0%}" if np.isfinite(margin) else "–",
            "least, anywhere in the string",
            margin < 0,
        ),
        _foretold(story, summary),
        Key("estimates good", f"{story.good / story.ticks:.0%}", "of the ticks"),
        _lost(story, summary),
    ]


def began(time_ns: int) -> str:
    """When a session began."""
    if time_ns < _UNIX_NS:
        return f"from {time_ns / 1e9:.1f} s by its own clock"
    return datetime.fromtimestamp(time_ns / 1e9, UTC).strftime("%d %B %Y, %H:%M:%S UTC")


def lasted(seconds: float) -> str:
    """A length of time as people say it."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


def losses(story: Story, summary: Summary) -> list[tuple[str, int | None]]:
    """Every count of something lost; None where nobody counted."""
    status = story.counts(summary.first_ns)
    rows: list[tuple[str, int | None]] = [
        (f"{channel.channel}: {name.replace('_', ' ')}", getattr(channel, name))
        for channel in (status.channels if status else ())
        for name in LOSSES
        if getattr(channel, name)
    ]
    rows += [
        ("slots skipped by the loop", status.slots_skipped if status else None),
        ("restarts of the estimator", status.restarts if status else None),
        ("messages not recorded", summary.dropped),
        ("estimates not good", story.ticks - story.good),
    ]
    return rows


def _foretold(story: Story, summary: Summary) -> Key:
    status = story.counts(summary.first_ns)
    if status is None or not status.HasField("sticks_foretold"):
        return Key("sticks foretold", "–", "none was counted")
    hit, missed = status.sticks_foretold, status.sticks_missed
    beside = f"{status.sticks_false} in vain"
    if status.HasField("stick_lead_s"):
        beside += f"; {status.stick_lead_s:.1f} s ahead on average"
    return Key("sticks foretold", f"{hit} of {hit + missed}", beside)


def _lost(story: Story, summary: Summary) -> Key:
    status = story.counts(summary.first_ns)
    if status is None:
        return Key("samples lost", "–", "no status was recorded")
    lost = sum(channel.lost for channel in status.channels)
    received = sum(channel.received for channel in status.channels)
    dropped = "unknown" if summary.dropped is None else str(summary.dropped)
    return Key("samples lost", f"{lost}", f"of {received + lost}; {dropped} messages not recorded", lost > 0)


def _rpm(speed: float) -> str:
    return f"{round(speed * RPM)}"


def _told(value: float, unit: str, digits: int = 0) -> str:
    return f"{value:.{digits}f} {unit}".rstrip() if np.isfinite(value) else "–"


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _of(values: Floats) -> Floats:
    known = values[np.isfinite(values)]
    return known if len(known) else np.array([np.nan])


def _most(values: Floats) -> float:
    return float(np.max(_of(values)))


def _least(values: Floats) -> float:
    return float(np.min(_of(values)))


def _middle(values: Floats) -> float:
    return float(np.median(_of(values)))
