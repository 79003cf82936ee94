"""Messages of a rig in, batches for the screen out; knows neither the bus nor Rerun nor a clock."""

import math
import time
from collections import defaultdict
from collections.abc import Iterator

from vsensor.messages import Estimate, Event, Message, Status, Tick
from vsensor.quality import Reason
from vsensor.units import factor
from vsensor.view import series, words
from vsensor.view.batches import Batch, Lane, LogLine, Page, Points
from vsensor.view.readings import KINDS, KNM, RPM, reading
from vsensor.view.trace import Trace

_MS_IN_S = factor("s", "ms")
_MS_IN_NS = factor("ns", "ms")

FAR_BACK_NS = 10_000_000_000
"""A source whose time falls back further than this has been set anew, or a replay begins again."""

PANEL_EVERY_NS = 500_000_000
"""Large numbers that change more often cannot be read."""


class Stream:
    """What a viewer is to be sent, collected message by message.

    Everything stands on the source's clock. Status bears the daemon's own, which may be years from that of
    a replayed source, so what it says is placed at the newest tick. The surface is drawn as the string feels
    it: `gear_ratio` (motor turns for one turn of the string) and `efficiency` as configured.
    """

    def __init__(self, gear_ratio: float = 1.0, efficiency: float = 1.0) -> None:
        self._surface_rpm = RPM / gear_ratio
        self._surface_knm = KNM * gear_ratio * efficiency
        self._lines: defaultdict[str, Trace] = defaultdict(Trace)
        self._bit = {(plot, kind): Trace() for plot in (series.SPEED, series.TORQUE) for kind in KINDS}
        self._others: list[Batch] = series.looks(None, None)
        self._events: set[str] = set()
        self._newest_ns = 0
        self._panel_ns = 0
        self._number: int | None = None
        self._missed = 0
        self._status = Status()
        self._estimate = Estimate()

    def falls_back(self, message: Message) -> bool:
        """Whether the source's clock went back so far that this message belongs into a new recording."""
        return isinstance(message, Tick) and message.time_ns < self._newest_ns - FAR_BACK_NS

    def take(self, message: Message) -> None:
        """Take in one message. Samples are passed over: the tick holds them as they were used."""
        match message:
            case Tick():
                self._take_tick(message)
            case Estimate():
                self._take_estimate(message)
            case Status():
                self._take_status(message)
            case Event():
                self._take_event(message)

    def silent(self, seconds: float, time_ns: int) -> None:
        """Say that nothing has come for `seconds`; `time_ns` places it where no message ever came."""
        self._newest_ns = self._newest_ns or time_ns
        self._page(series.PANEL, words.silence(seconds))

    def batches(self) -> Iterator[Batch]:
        """Hand over what has come since the last call."""
        yield from self._others
        self._others = []
        for entity, trace in self._lines.items():
            times, values = trace.take()
            if times.size:
                yield Points(entity, times, values[:, :1])
        for (plot, kind), trace in self._bit.items():
            times, values = trace.take()
            if times.size:
                value, deviation = values[:, :1], values[:, 1:]
                yield Points(series.bit(plot, kind), times, value)
                yield Points(series.band(plot, kind), times, value + deviation * [[2.0, -2.0]])

    def _take_tick(self, tick: Tick) -> None:
        if self._number is not None and tick.number > self._number + 1:
            self._missed += tick.number - self._number - 1
        self._number = tick.number
        self._newest_ns = tick.time_ns
        self._take_surface(tick)
        self._lines[series.EACH_TICK].add(tick.time_ns, tick.lateness_ns * _MS_IN_NS)
        if self._newest_ns - self._panel_ns >= PANEL_EVERY_NS:
            self._panel()

    def _take_surface(self, tick: Tick) -> None:
        """A held value was not measured, and is not drawn as if it were."""
        held = Reason(tick.reasons)
        speed = math.nan if held & Reason.STALE_SPEED else tick.motor_speed_rad_s
        torque = math.nan if held & Reason.STALE_TORQUE else tick.motor_torque_nm
        self._lines[series.surface(series.SPEED)].add(tick.time_ns, speed * self._surface_rpm)
        self._lines[series.surface(series.TORQUE)].add(tick.time_ns, torque * self._surface_knm)

    def _take_estimate(self, estimate: Estimate) -> None:
        self._estimate = estimate
        for kind in KINDS:
            found = reading(estimate, kind)
            self._bit[series.SPEED, kind].add(found.time_ns, found.speed, found.speed_std)
            self._bit[series.TORQUE, kind].add(found.time_ns, found.torque, found.torque_std)

    def _take_status(self, status: Status) -> None:
        before, self._status = self._status, status
        self._newest_ns = self._newest_ns or status.time_ns
        if status.state != before.state:
            level = "INFO" if status.state == "running" else "WARN"
            self._log(self._newest_ns, level, f"sensor: {status.state}")
            self._others.append(Lane(series.DAEMON, self._newest_ns, status.state))
        if _delays(status) != _delays(before):
            self._others.extend(series.looks(*_delays(status)))
        if status.HasField("severity"):
            self._lines[series.SEVERITY].add(self._newest_ns, status.severity)
        self._lines[series.P99].add(self._newest_ns, status.lateness_p99_s * _MS_IN_S)
        self._page(series.HEALTH, words.health(status, self._missed))
        self._panel()

    def _take_event(self, event: Event) -> None:
        verb, level = ("begins", "WARN") if event.begins else ("ends", "INFO")
        name = event.name.replace("_", " ")
        self._log(event.time_ns, level, f"{name} {verb}: {event.text}")
        if name not in self._events:
            self._events.add(name)
            self._others.append(series.event_look(name))
        self._others.append(Lane(series.event(name), event.time_ns, name if event.begins else ""))

    def _panel(self) -> None:
        self._panel_ns = self._newest_ns
        self._page(series.PANEL, words.panel(self._estimate, self._status))

    def _page(self, entity: str, text: str) -> None:
        self._others.append(Page(entity, self._newest_ns, text))

    def _log(self, time_ns: int, level: str, text: str) -> None:
        clock = time.strftime("%H:%M:%S", time.gmtime(time_ns // 1_000_000_000))
        self._others.append(LogLine(series.LOG, time_ns, level, f"{clock} {text}"))


def _delays(status: Status) -> tuple[float | None, float | None]:
    return (
        status.confirmed_delay_s if status.HasField("confirmed_delay_s") else None,
        status.forecast_horizon_s if status.HasField("forecast_horizon_s") else None,
    )
