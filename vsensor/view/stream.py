"""Messages of a rig in, batches for the screen out; knows neither the bus nor Rerun nor a clock."""

from collections.abc import Iterator

from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    SENSOR_TICK,
    STRING_DESCRIPTION,
    STRING_PROFILE,
    Estimate,
    Message,
    Status,
    Tick,
)
from vsensor.view import series
from vsensor.view.batches import Batch
from vsensor.view.blueprint import Reach
from vsensor.view.charts.portrait import Portrait
from vsensor.view.charts.spacetime import SpaceTime
from vsensor.view.charts.spectrum import Spectrum
from vsensor.view.charts.twist import Twist
from vsensor.view.charts.waves import Waves
from vsensor.view.glance import Glance
from vsensor.view.journal import Journal
from vsensor.view.part import Part
from vsensor.view.plots import Drive, Plots
from vsensor.view.service import Service
from vsensor.view.sound import sound
from vsensor.view.states import States
from vsensor.view.units import Units

TOPICS = (STRING_DESCRIPTION, SENSOR_STATUS, SENSOR_EVENT, SENSOR_TICK, BIT_ESTIMATE, STRING_PROFILE)
"""What is drawn, in the order in which it is best taken: the rest is drawn as a description says."""

FAR_BACK_NS = 10_000_000_000
"""A source whose time falls back further than this has been set anew, or a replay begins again."""

DRAWN_APART_NS = 1_900_000
"""Of a sensor faster than 500 Hz ticks so far apart are drawn: a string swings at some 5 Hz and less, and the
time that more take would be the sensor's own, where it runs on the same machine."""


class Stream:
    """What a viewer is to be sent, collected message by message.

    Everything stands on the source's clock. Status bears the daemon's own, which may be years from that of
    a replayed source, so what it says is placed at the newest tick.
    """

    def __init__(
        self, units: Units | None = None, drive: Drive | None = None, history_s: float = 30.0
    ) -> None:
        units, drive = units or Units(), drive or Drive()
        self._glance = Glance(units, drive)
        self._journal = Journal(units)
        self._service = Service()
        self._parts: tuple[Part, ...] = (
            Plots(units, drive),
            self._glance,
            States(),
            self._journal,
            SpaceTime(series.FIELD_TORQUE, "torque", units, history_s),
            SpaceTime(series.FIELD_SPEED, "speed", units, history_s),
            Waves(series.WAVES, units),
            Twist(series.TWIST),
            Portrait(series.PORTRAIT, units, history_s),
            Spectrum(series.SPECTRUM, units, history_s),
            self._service,
        )
        self._newest_ns = 0
        self._drawn_ns: dict[type[Message], int] = {}
        self.reach: Reach | None = None
        """How late answers are confirmed and how far they are foretold, once that is known."""

    @property
    def begun(self) -> bool:
        """Whether anything has come that can be drawn."""
        return self._newest_ns != 0

    def falls_back(self, message: Message) -> bool:
        """Whether the source's clock went back so far that this message belongs into a new recording."""
        return isinstance(message, Tick) and message.time_ns < self._newest_ns - FAR_BACK_NS

    def take(self, message: Message) -> None:
        """Take in one message; one that makes no sense is passed over."""
        if not self._is_drawn(message) or not sound(message):
            return
        if isinstance(message, Tick):
            self._newest_ns = message.time_ns
        elif isinstance(message, Status):
            self._newest_ns = self._newest_ns or message.time_ns
            if message.HasField("confirmed_delay_s"):
                self.reach = Reach(message.confirmed_delay_s, message.forecast_horizon_s)
        for part in self._parts:
            part.hear(message, self._newest_ns)

    def _is_drawn(self, message: Message) -> bool:
        """Whether a tick, or an estimate, is far enough from the last that was drawn."""
        if not isinstance(message, Tick | Estimate):
            return True
        since_ns = message.time_ns - self._drawn_ns.get(type(message), -DRAWN_APART_NS)
        if 0 <= since_ns < DRAWN_APART_NS:
            return False
        self._drawn_ns[type(message)] = message.time_ns
        return True

    def silent(self, seconds: float, time_ns: int) -> None:
        """Say that nothing has come for `seconds`; `time_ns` places it where no message ever came."""
        self._newest_ns = self._newest_ns or time_ns
        self._glance.silent(seconds, self._newest_ns)
        self._journal.silent(seconds, self._newest_ns)

    def waited(self, messages: int) -> None:
        """Note how many messages waited when the view looked."""
        self._service.waited(messages)

    def batches(self) -> Iterator[Batch]:
        """Hand over what has come since the last call."""
        for part in self._parts:
            yield from part.batches()
