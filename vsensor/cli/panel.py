"""A sensor's status as a page of a terminal."""

import math
import time
from collections import deque
from collections.abc import Iterable
from typing import Any

from rich.console import Group, RenderableType
from rich.panel import Panel as Frame
from rich.table import Table
from rich.text import Text

from vsensor.messages import Estimate, Event, Message, Status
from vsensor.messages.books import refused, words
from vsensor.messages.events import verb
from vsensor.messages.states import INPUT_LOST, RUNNING, STANDING_BY, STARTING, WAITING, WARMING_UP
from vsensor.quality import Quality, Reason
from vsensor.units import factor

RPM = factor("rad/s", "rpm")
SILENCE_S = 3.0
"""A status comes each second."""
EVENTS = 6
"""The newest are shown."""
STYLES = {
    STARTING: "yellow",
    STANDING_BY: "green",
    WAITING: "yellow",
    WARMING_UP: "yellow",
    RUNNING: "bold green",
    INPUT_LOST: "bold red",
}
QUALITIES = {Quality.GOOD: "green", Quality.UNCERTAIN: "yellow", Quality.BAD: "red"}
SHED = ("nothing", "the profile", "profile and forecast")


class Panel:
    """The newest of what a sensor says."""

    def __init__(self, status: Status) -> None:
        self.status = status
        self._estimate = Estimate()
        self._events: deque[Event] = deque(maxlen=EVENTS)
        self._heard = time.monotonic()

    def hear_all(self, told: Iterable[tuple[str, Message]]) -> None:
        """Take in what came over the bus."""
        for _, message in told:
            self._hear(message)

    def _hear(self, message: Message) -> None:
        if isinstance(message, Status):
            self.status, self._heard = message, time.monotonic()
        elif isinstance(message, Estimate):
            self._estimate = message
        elif isinstance(message, Event):
            self._events.appendleft(message)

    def shown(self) -> RenderableType:
        """The page."""
        parts = [self._head(), self._bit(), _inputs(self.status), _loop(self.status), _recording(self.status)]
        if self._events:
            parts.append(self._happened())
        apart = [part for each in parts for part in (each, Text())]
        return Group(*apart[:-1])

    def _head(self) -> RenderableType:
        status = self.status
        silent_s = time.monotonic() - self._heard
        state = Text(status.state, STYLES.get(status.state, "yellow"))
        if silent_s > SILENCE_S:
            state = Text(f"silent for {silent_s:.0f} s (was {status.state})", "bold red")
        line = Text.assemble((status.rig, "bold"), "  ", state)
        line.append(f"   vsensor {status.version}, up {_span(status.uptime_s)}", "dim")
        return Frame(line, border_style=state.style)

    def _bit(self) -> RenderableType:
        estimate, status = self._estimate, self.status
        table = _table("the bit", "speed (rpm)", "torque (kN·m)", "")
        quality = Quality(int(estimate.quality) or Quality.BAD)
        for kind, when in (
            ("confirmed", f"{status.confirmed_delay_s:.2f} s ago"),
            ("now", _quality_words(quality, Reason(estimate.reasons))),
            ("forecast", f"in {status.forecast_horizon_s:.2f} s"),
        ):
            if estimate.HasField(f"{kind}_bit_speed_rad_s"):  # type: ignore[arg-type]
                speed = _told(estimate, f"{kind}_bit_speed", "rad_s", RPM, ".1f")
                torque = _told(estimate, f"{kind}_bit_torque", "nm", 1e-3, ".2f")
                table.add_row(kind, speed, torque, when, style=QUALITIES[quality] if kind == "now" else "")
        if status.HasField("severity"):
            swing = f"severity {status.severity:.2f}"
            if status.HasField("stick_slip_period_s"):
                swing += f", period {status.stick_slip_period_s:.1f} s"
            table.add_row("swings", swing, f"stuck {status.stuck_share:.0%} of the time", "")
        sticks = f"foretold {status.sticks_foretold}, in vain {status.sticks_false}"
        bottom = "off bottom" if status.off_bottom else "on bottom"
        table.add_row("sticks", sticks, f"unannounced {status.sticks_missed}", bottom)
        return table

    def _happened(self) -> RenderableType:
        table = _table("events", "", "")
        for event in self._events:
            clock = time.strftime("%H:%M:%S", time.localtime(event.time_ns / 1e9))
            table.add_row(f"{clock}", verb(event), f"{event.name}: {event.text}")
        return table


def _inputs(status: Status) -> RenderableType:
    table = _table("input", "accepted", "refused", "lost", "age", "refused for")
    for channel in status.channels:
        age = f"{channel.age_s:.2f} s" if channel.HasField("age_s") else "never"
        bad = bool(refused(channel) or channel.lost)
        counts = (f"{channel.accepted:,}", f"{refused(channel):,}", f"{channel.lost:,}")
        table.add_row(channel.channel, *counts, age, words(channel), style="yellow" if bad else "")
    if status.bus_missed:
        table.add_row("missed", "", "", f"{status.bus_missed:,}", "", "on the bus", style="yellow")
    if status.restarts:
        table.add_row("began anew", f"{status.restarts}", "", "", "", "a long gap, or a clock that was set")
    return table


def _loop(status: Status) -> RenderableType:
    table = _table("loop", "median", "99 %", "")
    skipped = f"{status.slots_skipped:,} of {status.slots_due:,} turns skipped"
    told = {
        "woken late": ("lateness", skipped),
        "work": ("work", f"{status.load:.0%} busy at {status.rate_hz:g} Hz"),
        "publishing": ("publish", f"leaves out {SHED[min(status.shed, 2)]}"),
    }
    for name, (field, remark) in told.items():
        values = (getattr(status, f"{field}_{share}_s") * 1e3 for share in ("p50", "p99"))
        table.add_row(name, *(f"{value:.2f} ms" for value in values), remark)
    realtime = f"{status.realtime} ({status.scheduling})"
    has = {"memory locked": status.memory_locked, "processors kept awake": status.kept_awake}
    table.add_row("real time", realtime, "", ", ".join(words for words, there in has.items() if there))
    return table


def _recording(status: Status) -> RenderableType:
    table = _table("recording", "", "")
    if status.recording:
        size = f"{status.recording_bytes / 1e6:.1f} MB, {status.recording_free_bytes / 1e9:.1f} GB free"
        table.add_row("into", status.recording, size)
    else:
        why = status.recording_trouble or "nothing is recorded"
        table.add_row("none", why, "", style="red" if status.recording_trouble else "yellow")
    dropped = f"{status.recorder_dropped:,} not recorded"
    table.add_row("messages", f"{status.recorded:,}", dropped, style="red" if status.recorder_dropped else "")
    if status.learned_trouble:
        table.add_row("learned", status.learned_trouble, "not saved", style="red")
    return table


class _Rows(Table):
    def add_row(self, *cells: RenderableType | None, **settings: Any) -> None:
        """Words as they are: a folder's name may hold brackets, which would be a style."""
        super().add_row(*(Text(cell) if isinstance(cell, str) else cell for cell in cells), **settings)


def _table(title: str, *columns: str) -> Table:
    table = _Rows(box=None, pad_edge=False, padding=(0, 3, 0, 0), header_style="dim")
    table.add_column(title, style="bold", min_width=14, no_wrap=True)
    for column in columns:
        table.add_column(column)
    return table


def _told(estimate: Estimate, name: str, unit: str, scale: float, form: str) -> str:
    value, deviation = (getattr(estimate, f"{part}_{unit}") * scale for part in (name, f"{name}_std"))
    return f"{value:{form}} ± {deviation:{form}}" if math.isfinite(deviation) else f"{value:{form}}"


def _quality_words(quality: Quality, reasons: Reason) -> str:
    words = reasons.words()
    return quality.name.lower() + (f": {words}" if words else "")


def _span(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    for large, unit, small, fraction in (
        (days, "d", hours, "h"),
        (hours, "h", minutes, "min"),
        (minutes, "min", rest, "s"),
    ):
        if large:
            return f"{large} {unit} {small} {fraction}"
    return f"{rest} s"
