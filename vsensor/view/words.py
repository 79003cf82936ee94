"""What is read rather than seen: answers with their deviations, events, tables of losses. Markdown."""

import math
import time
from collections.abc import Callable

from vsensor.grid import NS
from vsensor.messages import Estimate, Event, Status
from vsensor.messages.books import LOSSES
from vsensor.messages.events import is_refusal, verb
from vsensor.view.readings import Reading, reading
from vsensor.view.units import Units

_WELCOME = ("received", "accepted")


def answers(estimate: Estimate, status: Status, units: Units) -> str:
    """The three answers with their deviations, and what severity means."""
    rows = [
        ["now", *_pairs(reading(estimate, "now", units), units)],
        [f"{status.confirmed_delay_s:.1f} s ago", *_pairs(reading(estimate, "confirmed", units), units)],
        [f"in {status.forecast_horizon_s:.1f} s", *_pairs(reading(estimate, "forecast", units), units)],
    ]
    return "\n\n".join([_table(["", "speed ± 2σ", "torque ± 2σ"], rows), *_swing(status), _formula(status)])


def _swing(status: Status) -> list[str]:
    if not status.HasField("stick_slip_period_s"):
        return []
    stuck = f", stuck {status.stuck_share:.0%} of the time" if status.stuck_share else ""
    return [f"It swings with a period of **{status.stick_slip_period_s:.1f} s**{stuck}."]


def _formula(status: Status) -> str:
    return (
        f"Severity = (max − min) / (2 mean) of the bit's speed over {status.severity_window_s:.0f} s: "
        "smooth below 0.5, stick-slip from 1 on, where the bit comes to a stand."
    )


def silence(seconds: float) -> str:
    """What is said when no message comes."""
    return (
        f"# No word for {seconds:.0f} s\n\n"
        "Nothing comes from the sensor: the daemon (vsensor run) is not up, or the way to it is cut. "
        "What is drawn here is old."
    )


def told(event: Event) -> tuple[str, str]:
    """An event as a line of the log: its level, and its words with the time of day."""
    name = event.name.replace("_", " ")
    level = "WARN" if event.begins or is_refusal(event) else "INFO"
    return level, f"{clock(event.time_ns)} {name if event.begins else f'{name} {verb(event)}'}: {event.text}"


def clock(time_ns: int) -> str:
    """The time of day, as the plots tell it (UTC)."""
    return time.strftime("%H:%M:%S", time.gmtime(time_ns // NS))


def health(status: Status, missed: int) -> str:
    """Every count of something lost, and how the loop keeps its time."""
    names = [channel.channel for channel in status.channels]
    return "\n\n".join(
        [
            "## Samples",
            _table(["", *names], [_channel_row(name, status) for name in (*_WELCOME, *LOSSES)]),
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


def _pairs(found: Reading, units: Units) -> tuple[str, str]:
    return (
        _pair(found.speed, found.speed_std, units.speed_text, units.speed),
        _pair(found.torque, found.torque_std, units.torque_text, units.torque),
    )


def _pair(value: float, deviation: float, text: Callable[[float], str], unit: str) -> str:
    if math.isnan(value):
        return "not known"
    band = "" if math.isnan(deviation) else f" ± {text(2 * deviation)}"
    return f"{text(value)}{band} {unit}"


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
