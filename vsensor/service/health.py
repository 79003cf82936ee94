"""What the daemon counts of itself, and the status that it makes of it once a second."""

import math
import time
from collections.abc import Iterable, Iterator, Mapping
from typing import Protocol

from vsensor import __version__
from vsensor.config import Rig
from vsensor.estimator.figures import BIT_SPEED, figures, period
from vsensor.estimator.severity import severity
from vsensor.grid import NS
from vsensor.messages import ChannelStatus, Status
from vsensor.service.engine import Engine
from vsensor.service.histogram import Histogram, quantile_s
from vsensor.service.pace import Slot
from vsensor.service.realtime import Achieved
from vsensor.service.shed import Shedding
from vsensor.service.sticks import Sticks

SILENCE_NS = NS
"""No sample on one of the channels for so long, by our own clock, and the input is lost."""


class Recorded(Protocol):
    """What the status tells of the recorder."""

    path: str
    sent: int
    figures: Mapping[str, float]
    """What it tells of itself, by the names of the status' fields."""

    @property
    def dropped(self) -> int:
        """Messages that are in no file though they should be."""

    def trouble(self) -> str:
        """What keeps it from recording; empty while all is well."""


class Keeps(Protocol):
    """What the status tells of the keeper."""

    trouble: str
    saved_ns: int


class Health:
    """Counts of the loop, and of the second that runs."""

    def __init__(self, rig: Rig, engine: Engine, sticks: Sticks, realtime: Achieved) -> None:
        self._rig = rig
        self._engine = engine
        self._sticks = sticks
        self.realtime = realtime
        self._started_ns = time.monotonic_ns()
        self._accepted = dict.fromkeys(engine.intake.channels, 0)
        self._heard_ns: dict[str, int] = {}
        self._lateness = Histogram()
        self._work = Histogram()
        self._input_age = Histogram()
        self._publish = Histogram()
        self._histograms = {
            "lateness": self._lateness,
            "work": self._work,
            "input_age": self._input_age,
            "publish": self._publish,
        }
        self._publishing_ns = 0
        self._prepared_ns = 0
        self._worked_ns = 0
        self._second_ns = self._started_ns
        for _ in self.look_back():
            pass
        self.load = 0.0
        """Share of the last second that the loop worked."""
        self.shedding = Shedding()
        self.grid_ns = 0
        """Slot 0 of the loop, monotonic clock."""
        self.bus_missed = 0
        """Surface samples that the bus lost."""
        self.inbox_waiting = 0
        """The most of them that waited for one turn in the last second."""
        self.status = Status()
        """The last that was made."""
        self.slots_run = 0
        self.slots_skipped = 0
        self.ticks = 0
        self.published = 0

    def begin(self, slot: Slot) -> None:
        """Count one turn of the loop, and those that passed before it."""
        self.slots_run += 1
        self.slots_skipped += slot.skipped
        self._lateness.note(slot.lateness_ns)

    def publishes(self, ns: int) -> None:
        """Note how long the bus took to take a message."""
        self._publishing_ns += ns

    def prepared(self, work_ns: int) -> None:
        """Note how long it took to prepare the slot that comes."""
        self._prepared_ns += work_ns

    def end(self, turn_ns: int) -> None:
        """Note how long the slot's work took, its turn and before, and how much went into publishing."""
        work_ns, self._prepared_ns = self._prepared_ns + turn_ns, 0
        self._work.note(work_ns)
        self._worked_ns += work_ns
        if self._publishing_ns:
            self._publish.note(self._publishing_ns)
            self._publishing_ns = 0

    def second(self) -> int:
        """Close a second's account; returns what is to be left out from now on."""
        now = time.monotonic_ns()
        self.load = self._worked_ns / max(now - self._second_ns, 1)
        self._second_ns, self._worked_ns = now, 0
        return self.shedding.second(self.load)

    def listen(self) -> None:
        """Note which channels have spoken since the last call, and how old the older one's word is."""
        now = time.monotonic_ns()
        for topic, channel in self._engine.intake.channels.items():
            if channel.counts.accepted != self._accepted[topic]:
                self._accepted[topic] = channel.counts.accepted
                self._heard_ns[topic] = now
        if len(self._heard_ns) == len(self._accepted):
            self._input_age.note(now - min(self._heard_ns.values()))

    @property
    def input_lost(self) -> bool:
        """Whether both channels have spoken, and one has not for a second, or both repeat themselves."""
        if len(self._heard_ns) < len(self._accepted):
            return False
        if self._engine.intake.frozen.silent:
            return True
        return time.monotonic_ns() - min(self._heard_ns.values()) > SILENCE_NS

    def look_back(self) -> Iterator[None]:
        """Work out the figures of the configured window, in parts, none of which takes long."""
        self.severity: float = severity(self._engine.recent[BIT_SPEED])
        window, apart_s = self._engine.window, self._engine.recent_s
        yield
        self._period_s = period(window[BIT_SPEED], apart_s)
        yield
        self._figures = figures(window, apart_s)

    def take_stock(
        self, state: str, recorder: Recorded | None, keeper: Keeps | None = None
    ) -> Iterator[None]:
        """Make the status of this moment, in parts like `look_back`; begins a new second."""
        status = Status(rig=self._rig.rig.name, version=__version__, state=state)
        self._tell_of_bit(status)
        yield
        self._tell_of_learned(status)
        yield
        self._tell_of_string(status)
        yield
        # All that is counted, at one moment.
        self._tell_of_loop(status)
        for name, histogram in self._histograms.items():
            getattr(status, name).CopyFrom(histogram.message())
        seconds = {name: histogram.turn_over() for name, histogram in self._histograms.items()}
        yield
        for name, second in seconds.items():
            if any(second):
                setattr(status, f"{name}_p50_s", quantile_s(second, 0.5))
                setattr(status, f"{name}_p99_s", quantile_s(second, 0.99))
        _tell_of_files(status, recorder, keeper)
        self.status = status

    def _tell_of_bit(self, status: Status) -> None:
        status.severity_window_s = self._rig.estimator.severity_window
        told = {"severity": self.severity, "stick_slip_period_s": self._period_s, **self._figures._asdict()}
        for name, value in told.items():
            if not math.isnan(value):
                setattr(status, name, value)

    def _tell_of_loop(self, status: Status) -> None:
        status.time_ns = time.time_ns()
        status.uptime_s = (time.monotonic_ns() - self._started_ns) / NS
        status.rate_hz = self._rig.loop.rate
        status.grid_ns = self.grid_ns
        status.slots_due = self.slots_run + self.slots_skipped
        status.slots_run = self.slots_run
        status.slots_skipped = self.slots_skipped
        status.ticks = self.ticks
        status.restarts = self._engine.intake.restarts
        status.published = self.published
        status.channels.extend(self._channels())
        status.bus_missed = self.bus_missed
        status.inbox_waiting = self.inbox_waiting
        status.load = self.load
        status.shed = self.shedding.level
        status.sheddings = self.shedding.count
        status.realtime = self.realtime.asked
        status.scheduling = self.realtime.scheduling
        status.processors = ",".join(map(str, self.realtime.processors))
        status.memory_locked = self.realtime.memory_locked
        status.kept_awake = self.realtime.kept_awake

    def _tell_of_learned(self, status: Status) -> None:
        estimator = self._engine.estimator
        law = estimator.law
        status.confirmed_delay_s = estimator.confirmed_delay
        status.forecast_horizon_s = estimator.forecast_horizon
        status.law_viscous_nm_s_rad, status.law_kinetic_nm = law.viscous_friction, law.kinetic_torque
        status.law_static_nm, status.law_stribeck_rad_s = law.static_torque, law.stribeck_speed
        corrections = zip(estimator.tuning.tolist(), estimator.tuning_std.tolist(), strict=True)
        (status.delay_correction, status.delay_correction_std) = next(corrections)
        (status.impedance_correction, status.impedance_correction_std) = next(corrections)
        (status.inertia_correction, status.inertia_correction_std) = next(corrections)
        (status.friction_correction, status.friction_correction_std) = next(corrections)
        (status.torque_offset_nm, status.torque_offset_std_nm) = next(corrections)
        status.rock_std_nm = estimator.rock_std
        status.bandwidth_hz = estimator.bandwidth

    def _tell_of_string(self, status: Status) -> None:
        status.string_length_m = self._engine.intake.depths.length
        status.depths_refused = self._engine.intake.depths.refused
        status.off_bottom = self._engine.intake.off_bottom
        status.depths_silent = self._engine.intake.depths_silent
        for ahead, speed, torque in self._engine.estimator.skill.tolist():
            skill = status.skill.add(ahead_s=ahead)
            if not math.isnan(speed):
                skill.speed_rms_rad_s, skill.torque_rms_nm = speed, torque
        status.sticks_foretold = self._sticks.foretold
        status.sticks_missed = self._sticks.missed
        status.sticks_false = self._sticks.false
        if self._sticks.foretold:
            status.stick_lead_s = self._sticks.lead_s

    def _channels(self) -> Iterable[ChannelStatus]:
        now = time.monotonic_ns()
        for topic, channel in self._engine.intake.channels.items():
            if topic in self._heard_ns:
                channel.counts.age_s = (now - self._heard_ns[topic]) / NS
            yield channel.counts


def _tell_of_files(status: Status, recorder: Recorded | None, keeper: Keeps | None) -> None:
    if keeper is not None and keeper.saved_ns:
        status.learned_saved_ns = keeper.saved_ns
    if keeper is not None and keeper.trouble:
        status.learned_trouble = keeper.trouble
    if recorder is None:
        return
    if trouble := recorder.trouble():
        status.recording_trouble = trouble
    elif recorder.path:
        status.recording = recorder.path
    for name, value in recorder.figures.items():
        setattr(status, name, value)
    status.recorded = recorder.sent
    status.recorder_dropped = recorder.dropped
