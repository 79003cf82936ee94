"""What the driller reads: the panel in large plain words, and the tables of losses. Markdown."""

import math

from vsensor.messages import ChannelStatus, Estimate, Status
from vsensor.quality import Quality, Reason
from vsensor.view.readings import Reading, reading

_WELCOME = ("received", "accepted")
_COUNTS = [field.name for field in ChannelStatus.DESCRIPTOR.fields if field.type == field.TYPE_FIXED64]
_REFUSALS = [name for name in _COUNTS if name not in _WELCOME]


def panel(estimate: Estimate, status: Status) -> str:
    """The bit now, how rough it runs, and how far this can be trusted."""
    return "\n\n".join(
        [
            f"# {_bit(estimate, status)}",
            f"# {_severity(status)}",
            _answers(estimate, status),
            f"Sensor **{status.state}**, estimate **{_quality(estimate)}**",
            _formula(status),
        ]
    )


def silence(seconds: float) -> str:
    """The panel when no message comes."""
    return (
        f"# No word for {seconds:.0f} s\n\n"
        "Nothing comes from the sensor: the daemon (vsensor run) is not up, or the way to it is cut. "
        "What is drawn here is old."
    )


def health(status: Status, missed: int) -> str:
    """Every count of something lost, and how the loop keeps its time."""
    names = [channel.channel for channel in status.channels]
    return "\n\n".join(
        [
            "## Samples",
            _table(["", *names], [_channel_row(name, status) for name in (*_WELCOME, *_REFUSALS)]),
            "## Other losses",
            _table(
                ["", "count"],
                [
                    [f"slots skipped by the loop, of {status.slots_due}", _loss(status.slots_skipped)],
                    ["restarts of the estimator", _loss(status.restarts)],
                    ["messages that the recorder could not take", _loss(status.recorder_dropped)],
                    ["ticks that this view has missed", _loss(missed)],
                ],
            ),
            "## Timing",
            _table(
                [f"last second at {status.rate_hz:g} Hz", "median", "99 % below"],
                [
                    ["lateness", _us(status.lateness_p50_s), _us(status.lateness_p99_s)],
                    ["work", _us(status.work_p50_s), _us(status.work_p99_s)],
                ],
            ),
            f"Up {status.uptime_s:.0f} s. Recording: {status.recording or 'none'}.",
        ]
    )


def _bit(estimate: Estimate, status: Status) -> str:
    now = reading(estimate, "now")
    if _grade(estimate) in (None, Quality.BAD) or math.isnan(now.speed):
        return f"Bit not known: {status.state or 'no status yet'}"
    return f"Bit {now.speed:.0f} rpm, {now.torque:.1f} kN·m"


def _severity(status: Status) -> str:
    """The severity in words. From 1 on the bit comes to a stand; half of that is our own bound."""
    if not status.HasField("severity"):
        return "Stick-slip not known yet"
    if status.severity >= 1.0:
        return f"STICK-SLIP, severity {status.severity:.2f}"
    return f"{'Uneven' if status.severity >= 0.5 else 'Smooth'}, severity {status.severity:.2f}"


def _formula(status: Status) -> str:
    return (
        f"Severity = (max − min) / (2 mean) of the bit's speed over {status.severity_window_s:.0f} s: "
        "smooth below 0.5, stick-slip from 1 on, where the bit comes to a stand."
    )


def _answers(estimate: Estimate, status: Status) -> str:
    return _table(
        ["", "speed ± 2σ", "torque ± 2σ"],
        [
            ["now", *_pairs(reading(estimate, "now"))],
            [f"{status.confirmed_delay_s:.1f} s ago", *_pairs(reading(estimate, "confirmed"))],
            [f"in {status.forecast_horizon_s:.1f} s", *_pairs(reading(estimate, "forecast"))],
        ],
    )


def _pairs(found: Reading) -> tuple[str, str]:
    return (
        _pair(found.speed, found.speed_std, 0, "rpm"),
        _pair(found.torque, found.torque_std, 1, "kN·m"),
    )


def _pair(value: float, deviation: float, digits: int, unit: str) -> str:
    if math.isnan(value):
        return "not known"
    band = "" if math.isnan(deviation) else f" ± {2 * deviation:.{digits}f}"
    return f"{value:.{digits}f}{band} {unit}"


def _quality(estimate: Estimate) -> str:
    grade = _grade(estimate)
    if grade is None:
        return "not known"
    reasons = Reason(estimate.reasons).words()
    return grade.name.lower() + (f" ({reasons})" if reasons else "")


def _grade(estimate: Estimate) -> Quality | None:
    """None where there is no verdict yet, or one that a newer daemon has and we do not know."""
    return next((grade for grade in Quality if int(grade) == int(estimate.quality)), None)


def _channel_row(name: str, status: Status) -> list[str]:
    counts = [getattr(channel, name) for channel in status.channels]
    return [name.replace("_", " "), *(str(n) if name in _WELCOME else _loss(n) for n in counts)]


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _loss(number: int) -> str:
    return f"**{number}**" if number else "0"


def _us(seconds: float) -> str:
    return f"{seconds * 1e6:.0f} µs"
